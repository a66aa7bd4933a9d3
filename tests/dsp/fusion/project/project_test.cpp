#include "dsp/fusion/project/project.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "tests/support/kernel_check.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

struct Point {
  int u;
  int v;
  int depth;
  friend bool operator==(const Point&, const Point&) = default;
};

Point run(std::array<std::int16_t, 3> ray, QuarterMm distance, const Projection& projection) {
  std::int32_t u = 7;
  std::int32_t v = 7;
  QuarterMm depth = 7;
  best::project({{ray.data(), 1}, {ray.data() + 1, 1}, {ray.data() + 2, 1}}, {&distance, 1},
                projection, {&u, 1}, {&v, 1}, {&depth, 1});
  return {u, v, depth};
}

constexpr Projection kCamera{
    .origin = {0, 1200, 800}, .focal_x = 1600, .focal_y = 1600, .centre_x = 3200, .centre_y = 1600};

TEST(Project, PutsAPointWhereThePinholeDoes) {
  // Straight ahead of a PMD camera 0.3 m below and 0.2 m before: (0, 0.3, 2.2) m.
  EXPECT_EQ(run({0, 0, 32767}, 8000, kCamera), (Point{3200, 1600 + 218, 8800}));
  EXPECT_EQ(run({23170, 0, 23170}, 8000, {.focal_x = 1600, .focal_y = 1600}),
            (Point{1600, 0, 5657}));
}

TEST(Project, LeavesOutMissingPointsAndThoseBehindTheCamera) {
  EXPECT_EQ(run({0, 0, 32767}, 0, kCamera), (Point{0, 0, 0}));
  EXPECT_EQ(run({0, 0, -32767}, 800, kCamera), (Point{0, 0, 0}));  // Z = 0
  EXPECT_EQ(run({0, 0, -32767}, 8000, kCamera), (Point{0, 0, 0}));
  EXPECT_EQ(run({0, 0, -32767}, 799, kCamera).depth, 1);
}

TEST(Project, ClampsFarPlacesAndSaturatesDepth) {
  const Projection camera{.origin = {400000, -400000, 1}, .focal_x = 16000, .focal_y = 16000};
  EXPECT_EQ(run({0, 0, 0}, 1, camera), (Point{kFarthestPosition, -kFarthestPosition, 1}));
  EXPECT_EQ(run({0, 0, 32767}, 65535, kCamera).depth, 65535);
}

TEST(Project, StaysWithinAStepOfDoubleInsideTheImage) {
  test::Random random(3);
  for (int i = 0; i < 20000; ++i) {
    const std::array<std::int16_t, 3> ray{static_cast<std::int16_t>(random.between(-16000, 16000)),
                                          static_cast<std::int16_t>(random.between(-16000, 16000)),
                                          static_cast<std::int16_t>(random.between(24000, 32767))};
    const QuarterMm distance = static_cast<QuarterMm>(random.between(1000, 65535));
    const Point point = run(ray, distance, kCamera);
    const double z = distance * (ray[2] / 32768.0) + 800;
    const double u = 1600 * (distance * (ray[0] / 32768.0)) / z + 3200;
    const double v = 1600 * (distance * (ray[1] / 32768.0) + 1200) / z + 1600;
    // 0.57 steps of 1/16 px, and half a quarter millimetre sideways at 0.25 m or more.
    ASSERT_NEAR(point.u, u, 0.57 + 1600 * 1.0 / z);
    ASSERT_NEAR(point.v, v, 0.57 + 1600 * 1.5 / z);
    ASSERT_NEAR(point.depth, std::min(z, 65535.0), 0.51);
  }
}

TEST(Project, EqualsReferenceForEveryLengthAndExtreme) {
  for (int variant = 0; variant < 4; ++variant) {
    test::check_kernel([&](test::KernelCase& c) {
      const std::size_t n = c.length();
      const RayRow rays{
          c.array<std::int16_t>(n, -32767, 32767), c.array<std::int16_t>(n, -32767, 32767),
          c.array<std::int16_t>(n, variant == 0 ? 0 : -32767, variant == 1 ? 3 : 32767)};
      const auto distance = c.array<QuarterMm>(n, 0, variant == 2 ? 2 : 65535);
      const std::size_t empty = std::min(n, std::size_t{16});  // whole vectors without a reading
      std::ranges::fill(distance.first(n % 3 == 0 ? empty : 0), kNoDepth);
      Projection camera{.focal_x = static_cast<float>(c.draw(1, 60000)),
                        .focal_y = static_cast<float>(c.draw(1, 60000)),
                        .centre_x = static_cast<float>(c.draw(-60000, 60000)),
                        .centre_y = static_cast<float>(c.draw(-60000, 60000))};
      for (std::int32_t& origin : camera.origin) {
        origin = variant == 3 ? c.draw(-400000, 400000) : c.draw(-2, 2);
      }
      const auto u = c.array<std::int32_t>(n), v = c.array<std::int32_t>(n);
      const auto depth = c.array<QuarterMm>(n);
      c.run([&] { best::project(rays, distance, camera, u, v, depth); });
    });
  }
}

}  // namespace
}  // namespace stof::dsp
