#include "dsp/fusion/drift/picture_shift.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded_part.h"

namespace stof::dsp {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;

// A wall with things on it, moved by (x, y).
class Picture {
 public:
  Picture(double x, double y, std::uint32_t seed = 0, double contrast = 1) {
    std::minstd_rand random(seed + 1);
    std::normal_distribution<double> noise(0, 2.5);
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        const double grey = 120 + contrast * of(u - x, v - y) + (seed == 0 ? 0 : noise(random));
        pixels_.push_back(static_cast<std::uint8_t>(std::clamp(std::lround(grey), 0L, 255L)));
      }
    }
  }
  ImageView<const std::uint8_t> view() const { return {pixels_.data(), kWidth, kHeight}; }

 private:
  static double edge(double at) { return std::tanh(at / 2); }
  static double of(double u, double v) {
    return 30 * (edge(u - 70) - edge(u - 95)) + 20 * (edge(u - 201) - edge(u - 262)) -
           25 * (edge(v - 60) - edge(v - 84)) + 15 * (edge(v - 150) - edge(v - 221)) +
           8 * std::sin(u / 7) * std::cos(v / 5);
  }
  std::vector<std::uint8_t> pixels_;
};

std::optional<Shift> seen(const Picture& before, const Picture& now) {
  test::GuardedPart<PictureShift> shift(
      [](Arena& arena) { return PictureShift(kWidth, kHeight, arena); });
  EXPECT_FALSE(shift->look(before.view()));
  return shift->look(now.view());
}

TEST(PictureShift, IsFoundInBothDirections) {
  for (const double x : {-20.0, -3.5, 0.0, 7.0, 24.3}) {
    for (const double y : {-9.0, 0.0, 4.6}) {
      const std::optional<Shift> shift = seen({0, 0}, {x, y});
      ASSERT_TRUE(shift) << x << ", " << y;
      EXPECT_NEAR(shift->x, x, 0.3);
      EXPECT_NEAR(shift->y, y, 0.3);
    }
  }
}

TEST(PictureShift, NoiseOfAStandingCameraIsNone) {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    const std::optional<Shift> shift = seen({0, 0, seed}, {0, 0, seed + 100});
    ASSERT_TRUE(shift);
    EXPECT_EQ(shift->x, 0);
    EXPECT_EQ(shift->y, 0);
  }
}

TEST(PictureShift, IsFoundInNoiseAndOtherLight) {
  const std::optional<Shift> shift = seen({0, 0, 5}, {6, -3, 6, 0.9});
  ASSERT_TRUE(shift);
  EXPECT_NEAR(shift->x, 6, 0.5);
  EXPECT_NEAR(shift->y, -3, 0.5);
}

TEST(PictureShift, OfAnotherPictureNobodyKnows) {
  EXPECT_FALSE(seen({0, 0}, {-90, 100}));  // another part of the wall
}

TEST(PictureShift, BeginsAnewAfterAGap) {
  test::GuardedPart<PictureShift> shift(
      [](Arena& arena) { return PictureShift(kWidth, kHeight, arena); });
  const Picture picture(0, 0);
  EXPECT_FALSE(shift->look(picture.view()));
  EXPECT_TRUE(shift->look(picture.view()));
  shift->forget();
  EXPECT_FALSE(shift->look(picture.view()));
}

TEST(PictureShift, SmallPicturesSayNothing) {
  const std::vector<std::uint8_t> pixels(300, 7);
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(300, 1), std::pair(1, 300)}) {
    test::GuardedPart<PictureShift> shift(
        [w = width, h = height](Arena& arena) { return PictureShift(w, h, arena); });
    for (int i = 0; i < 3; ++i) {
      EXPECT_FALSE(shift->look({pixels.data(), width, height}));
    }
  }
}

}  // namespace
}  // namespace stof::dsp
