#include "host/calibrate/rig/extrinsics/corner_noise.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/host/calibrate/rig/gaussian.h"

namespace stof::host {
namespace {

using test::Gaussian;

// Corners whose covariances differ tenfold, and lie askew.
std::vector<CornerOff> drawn(std::size_t count, const CornerNoise& noise, Gaussian& random) {
  std::vector<CornerOff> corners;
  for (std::size_t i = 0; i < count; ++i) {
    const double wide = random.between(0.01, 0.1);
    const double narrow = wide * random.between(0.3, 1);
    const double angle = random.between(0, 3);
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    const double a = random.next(wide * std::sqrt(noise.scale));
    const double b = random.next(narrow * std::sqrt(noise.scale));
    corners.push_back({.found = {.uu = c * c * wide * wide + s * s * narrow * narrow,
                                 .uv = c * s * (wide * wide - narrow * narrow),
                                 .vv = s * s * wide * wide + c * c * narrow * narrow},
                       .u = c * a - s * b + random.next(std::sqrt(noise.floor)),
                       .v = s * a + c * b + random.next(std::sqrt(noise.floor))});
  }
  return corners;
}

TEST(CornerNoise, TellsBothComponentsApart) {
  Gaussian random(1);
  for (const CornerNoise& truth :
       {CornerNoise{.scale = 2, .floor = 0.0009}, CornerNoise{.scale = 0.25, .floor = 0.0001}}) {
    const CornerNoise found = corner_noise(drawn(4000, truth, random), 1, {});
    EXPECT_NEAR(found.scale / truth.scale, 1, 0.15);
    EXPECT_NEAR(found.floor / truth.floor, 1, 0.15);
  }
}

TEST(CornerNoise, OneThatIsNotThereIsNone) {
  Gaussian random(2);
  const CornerNoise found = corner_noise(drawn(4000, {.scale = 1, .floor = 0}, random), 1, {});
  EXPECT_NEAR(found.scale, 1, 0.1);
  EXPECT_LT(found.floor, 2e-5);
}

TEST(CornerNoise, UnknownsThatWereFittedTookSomeOfIt) {
  Gaussian random(3);
  const std::vector<CornerOff> corners = drawn(1000, {.scale = 1, .floor = 0.0004}, random);
  const CornerNoise all = corner_noise(corners, 1, {});
  const CornerNoise left = corner_noise(corners, 0.8, {});
  EXPECT_NEAR(left.scale / all.scale, 1.25, 0.05);
  EXPECT_NEAR(left.floor / all.floor, 1.25, 0.05);
}

// Corners that count alike, as those of before, and some that are not those.
TEST(CornerNoise, AFewWrongCornersMakeLittleOfADifference) {
  Gaussian random(4);
  std::vector<CornerOff> corners;
  for (int i = 0; i < 1000; ++i) {
    const double far = i % 100 == 0 ? 5 : 1;
    corners.push_back({.found = {}, .u = far * random.next(0.07), .v = far * random.next(0.07)});
  }
  const CornerNoise found = corner_noise(corners, 1, {});
  EXPECT_NEAR(std::sqrt(found.scale + found.floor), 0.07, 0.007);
  EXPECT_GT(corner_noise({}, 1, {.scale = 1, .floor = 0.01}).floor, 0);
}

}  // namespace
}  // namespace stof::host
