#include "dsp/fusion/project/pmd_view.h"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "dsp/calib/pmd/ray_table.h"

namespace stof::dsp {
namespace {

Calibration rig() {
  Calibration calibration;
  calibration.stereo.left = {
      .width = 640, .height = 480, .fx = 560, .fy = 561, .cx = 319.5, .cy = 239.5};
  calibration.pmd.lens = {.width = 176,
                          .height = 144,
                          .fx = 170,
                          .fy = 171,
                          .cx = 86.2,
                          .cy = 71.3,
                          .k1 = -0.06,
                          .k2 = 0.01,
                          .p1 = 0.001,
                          .p2 = -0.002};
  const double turn = 0.02;
  calibration.pmd_to_stereo = {
      .rotation = {std::cos(turn), 0, std::sin(turn), 0, 1, 0, -std::sin(turn), 0, std::cos(turn)},
      .translation_m = {0.05, -0.03, 0.02}};
  return calibration;
}

// What each PMD pixel sees at some distance comes back to it.
TEST(PmdView, IsTheWayBackOfProjection) {
  const Calibration calibration = rig();
  const Pinhole& left = calibration.stereo.left;
  const PmdView view(calibration);
  const auto& r = calibration.pmd_to_stereo.rotation;
  const auto& t = calibration.pmd_to_stereo.translation_m;
  int asked = 0;
  for (int row = 0; row < 144; row += 7) {
    for (int column = 0; column < 176; column += 5) {
      const std::array<double, 3> ray = unit_ray(calibration.pmd.lens, column, row);
      for (const double distance : {0.7, 3.0, 12.0}) {
        std::array<double, 3> point{};
        for (std::size_t k = 0; k < 3; ++k) {
          point[k] =
              t[k] + distance * (r[3 * k] * ray[0] + r[3 * k + 1] * ray[1] + r[3 * k + 2] * ray[2]);
        }
        const int x = static_cast<int>(std::lround(left.fx * point[0] / point[2] + left.cx));
        const int y = static_cast<int>(std::lround(left.fy * point[1] / point[2] + left.cy));
        const PmdView::Place place =
            view.of(x, y, static_cast<float>(kQuarterMmPerMetre * point[2]));
        ASSERT_TRUE(place.seen()) << column << "," << row;
        EXPECT_NEAR(place.column, column, 1);
        EXPECT_NEAR(place.row, row, 1);
        EXPECT_NEAR(place.distance, kQuarterMmPerMetre * distance, 2 + 8 * distance);
        ++asked;
      }
    }
  }
  EXPECT_GT(asked, 2000);
}

TEST(PmdView, SeesNothingBehindItOrBesideItsPicture) {
  Calibration calibration = rig();
  const PmdView view(calibration);
  EXPECT_FALSE(view.of(320, 240, 40).seen());  // 1 cm before the left camera: behind the PMD's
  EXPECT_FALSE(view.of(-4000, 240, 8000).seen());
  EXPECT_FALSE(view.of(320, 9000, 8000).seen());
  // Far aside, where the lens would fold it back into the picture.
  calibration.pmd.lens.k1 = -0.5;
  EXPECT_FALSE(PmdView(calibration).of(2400, 240, 8000).seen());
}

}  // namespace
}  // namespace stof::dsp
