#include "dsp/calib/calibration.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace stof::dsp {
namespace {

Calibration usable() {
  Calibration c;
  c.stereo = {.left = {.width = 640, .height = 480, .fx = 500, .fy = 500, .cx = 319.5, .cy = 239.5},
              .baseline_m = 0.12,
              .doff_px = 0};
  c.pmd.lens = {.width = 64, .height = 16, .fx = 45, .fy = 45, .cx = 31.5, .cy = 7.5};
  return c;
}

TEST(Calibration, UsableOneHasNoProblem) { EXPECT_EQ(problem(usable()), std::string()); }

TEST(Calibration, StereoOnlyNeedsNoPmd) {
  Calibration c = usable();
  c.pmd = {};
  EXPECT_EQ(problem(c), std::string());
}

TEST(Calibration, EveryUnusableNumberIsNamed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Calibration c = usable();
  c.stereo.left.fx = nan;
  EXPECT_NE(problem(c), std::string());
  c = usable();
  c.stereo.baseline_m = 0;
  EXPECT_NE(problem(c), std::string());
  c = usable();
  c.pmd_to_stereo.rotation[0] = 0.9;
  EXPECT_NE(problem(c), std::string());
  c = usable();
  c.pmd_to_stereo.translation_m[1] = nan;
  EXPECT_NE(problem(c), std::string());
  c = usable();
  c.pmd.tone.modulation = Hertz{5'000'000};
  EXPECT_NE(problem(c), std::string());
  c = usable();
  c.pmd.electrons_per_lsb = 0;
  EXPECT_NE(problem(c), std::string());
  c = usable();
  const std::vector<std::int16_t> short_map(10);
  c.pmd.fixed_pattern = short_map;
  EXPECT_NE(problem(c), std::string());
}

TEST(Calibration, AMirrorIsNotARotation) {
  Calibration c = usable();
  c.pmd_to_stereo.rotation = {1, 0, 0, 0, -1, 0, 0, 0, 1};
  EXPECT_NE(problem(c), std::string());
}

TEST(Calibration, IncludesTheRawOrConvergingPair) {
  Calibration c = usable();
  c.stereo.converging =
      Converging{.f1_m = 0.004, .f2_m = 0.004, .pixel_m = 8e-6, .cx_left = 319.5, .cx_right = 300};
  EXPECT_EQ(complete(c.stereo), std::string());
  EXPECT_EQ(problem(c), std::string());
  EXPECT_EQ(c.stereo.doff_px, -19.5);
  c.stereo.converging->pixel_m = 0;
  EXPECT_NE(problem(c), std::string());
  c = usable();
  RawPair& pair = c.stereo.raw.emplace();
  pair.left = pair.right = c.stereo.left;
  pair.left_to_right.translation_m = {-0.1, 0, 0};
  EXPECT_EQ(complete(c.stereo), std::string());
  EXPECT_EQ(problem(c), std::string());
  EXPECT_NEAR(c.stereo.baseline_m, 0.1, 1e-12);
  pair.left_to_right.translation_m = {0, 0, 0};
  EXPECT_NE(problem(c), std::string());
}

TEST(WigglingTable, HoldsFourPeriodsOfTheAmplitude) {
  // 0.0386 rad is 403 steps of 1/65536 turn; sin(4 phi) peaks at a sixteenth of a turn.
  const WigglingTable table = fourth_harmonic_table(0.0386);
  EXPECT_EQ(table[0], 0);
  EXPECT_EQ(table[8], std::lround(0.0386 / (2 * std::numbers::pi) * 65536));
  EXPECT_EQ(table[24], -table[8]);
  for (std::size_t i = 0; i < 96; ++i) {
    EXPECT_EQ(table[i], table[i + 32]);
  }
}

}  // namespace
}  // namespace stof::dsp
