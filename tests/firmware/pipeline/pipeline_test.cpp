#include "firmware/pipeline/pipeline.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "dsp/calib/stereo/rectification.h"
#include "dsp/stereo/rectify/rectifier.h"
#include "dsp/stereo/rectify/rectify.h"
#include "hal/emu/devices/clock.h"
#include "tests/dsp/pmd/converter_rig.h"
#include "tests/dsp/stereo/raw_pair_scene.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/guarded_part.h"

namespace stof::firmware {
namespace {

namespace raw = dsp::raw;

constexpr int kWidth = 240;
constexpr int kHeight = 160;

class NoOwner final : public hal::SlotOwner {
 public:
  void give_back(int) noexcept override {}
};

// A plane before two cameras as they are; the appliance gets their pictures and calibration.
TEST(Pipeline, MeasuresAPlaneWithRawCameras) {
  const dsp::RawPair pair = raw::raw_pair(kWidth, kHeight, 0.3);
  const raw::Plane plane;
  stof::test::GuardedImage<std::uint8_t> left(kWidth, kHeight, kWidth);
  stof::test::GuardedImage<std::uint8_t> right(kWidth, kHeight, kWidth);
  constexpr double kShortestWave = 0.035;  // m, about 5 px
  raw::render(left.view(), kShortestWave,
              [&](double u, double v) { return raw::seen_by_left(pair, plane, u, v); });
  raw::render(right.view(), kShortestWave,
              [&](double u, double v) { return raw::seen_by_right(pair, plane, u, v); });

  firmware::Setup setup;  // gtest has a Setup too
  setup.calibration.stereo.raw = pair;
  ASSERT_STREQ(dsp::complete(setup.calibration.stereo), "");
  ASSERT_STREQ(dsp::problem(setup.calibration), "");
  setup.depth.match = {
      .min_disparity = static_cast<int>(std::floor(-setup.calibration.stereo.doff_px)),
      .disparities = 48,
      .block_width = 13,
      .block_height = 13,
      .left_right_tolerance = 1,
      .subpixel = dsp::Subpixel::kEquiangular};
  hal::emu::Clock clock;
  stof::test::GuardedPart<Pipeline> pipeline(
      [&](dsp::Arena& arena) { return Pipeline(setup, arena); });
  NoOwner owner;
  hal::StereoFrame frame;
  frame.left = left.view();
  frame.right = right.view();
  const Shot shot{.edge = {},
                  .exposed = {},
                  .stereo = hal::BorrowedFrame<hal::StereoFrame>(frame, owner, 0),
                  .pmd = std::nullopt,
                  .pmd_exposed = std::nullopt};
  const Output& output = pipeline->compute(shot, clock);

  const dsp::Rectification rectified = dsp::rectify(pair);
  const dsp::SourceMap map(pair.left, rectified.left_turn, rectified.left);
  int measured = 0;
  int held = 0;
  int outside = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const int depth = output.map.depth.at(x, y);
      if (!map.at(x, y).inside) {
        EXPECT_EQ(depth, 0) << x << ", " << y;
        ++outside;
      } else if (depth != 0) {
        const double z = raw::behind_rectified(rectified, plane, x, y).z * dsp::kQuarterMmPerMetre;
        ++measured;
        held += std::abs(z - depth) <= output.map.width.at(x, y) / 2.0 + 1 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(outside, kWidth * kHeight / 50);
  EXPECT_GT(measured, kWidth * kHeight * 7 / 10);
  EXPECT_GT(held, measured * 97 / 100);
  EXPECT_EQ(output.stats.sources[0], static_cast<std::uint32_t>(kWidth * kHeight - measured));
}

// 1.5 m/s for 6 ms: what moves while it is sampled may be 9 mm nearer or further for the pair.
TEST(Pipeline, ALaterPmdExposureOfWhatMovesHasLongerIntervals) {
  firmware::Setup setup;
  setup.calibration.stereo.left = {
      .width = kWidth, .height = kHeight, .fx = 200, .fy = 200, .cx = 119.5, .cy = 79.5};
  setup.calibration.stereo.baseline_m = 0.1;
  ASSERT_STREQ(dsp::complete(setup.calibration.stereo), "");
  dsp::PmdSensor& sensor = setup.calibration.pmd;
  sensor.lens = {.width = 64, .height = 48, .fx = 90, .fy = 90, .cx = 31.5, .cy = 23.5};
  sensor.dark_lsb = 100;
  ASSERT_STREQ(dsp::problem(setup.calibration), "");
  dsp::Planes planes(64, 48);
  planes.show_everywhere(3, 1500, 600);
  for (std::size_t k = 0; k < 4; ++k) {
    for (std::uint16_t& sample : planes.planes[k]) {  // grows brighter
      sample = static_cast<std::uint16_t>(sample + 50 * k);
    }
  }
  hal::emu::Clock clock;
  stof::test::GuardedPart<Pipeline> pipeline(
      [&](dsp::Arena& arena) { return Pipeline(setup, arena); });
  NoOwner owner;
  const auto width_with = [&](hal::Duration lag) {
    hal::PmdFrame frame;
    frame.samples = planes.samples();
    const Shot shot{.edge = {},
                    .exposed = {},
                    .stereo = std::nullopt,
                    .pmd = hal::BorrowedFrame<hal::PmdFrame>(frame, owner, 0),
                    .pmd_exposed = hal::Time{} + lag};
    return pipeline->compute(shot, clock).map.width.at(kWidth / 2, kHeight / 2);
  };
  const int at_once = width_with({});
  EXPECT_GT(at_once, 0);
  EXPECT_EQ(width_with(std::chrono::milliseconds(6)), at_once + 2 * 36);
}

}  // namespace
}  // namespace stof::firmware
