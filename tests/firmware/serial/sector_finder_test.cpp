#include "firmware/serial/sector_finder.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded_part.h"
#include "tests/support/random.h"

namespace stof::firmware::test {
namespace {

using stof::test::Random;

constexpr double kRadian = 180 / std::numbers::pi;
constexpr dsp::Pinhole kLens{
    .width = 640, .height = 480, .fx = 500, .fy = 500, .cx = 320, .cy = 240};
constexpr SectorParams kAll{
    .obstacle = {.above_mm = 10'000, .below_mm = 10'000, .pixels = 1, .least_mm = 100},
    .most_mm = 16'000};

// A finder, its memory and a map for it.
struct World {
  explicit World(const dsp::Pinhole& seen = kLens, const SectorParams& params = kAll)
      : lens(seen),
        in_memory([&](dsp::Arena& arena) { return SectorFinder(lens, params, arena); }),
        depth(static_cast<std::size_t>(lens.width * lens.height)),
        width(depth.size()) {}

  dsp::DepthMap map() {
    return {.depth = {depth.data(), lens.width, lens.height},
            .width = {width.data(), lens.width, lens.height},
            .source = {}};
  }
  const Sectors& find() { return finder.find(map()); }
  void fill(int quarter_mm, int interval) {
    std::ranges::fill(depth, static_cast<dsp::QuarterMm>(quarter_mm));
    std::ranges::fill(width, static_cast<dsp::QuarterMm>(interval));
  }
  // A rectangle of pixels.
  void paint(int x, int y, int columns, int rows, int quarter_mm, int interval) {
    for (int v = y; v < y + rows; ++v) {
      for (int u = x; u < x + columns; ++u) {
        map().depth.at(u, v) = static_cast<dsp::QuarterMm>(quarter_mm);
        map().width.at(u, v) = static_cast<dsp::QuarterMm>(interval);
      }
    }
  }
  std::size_t sector_of(int column) const {
    const double left = std::atan((-0.5 - lens.cx) / lens.fx);
    const double right = std::atan((lens.width - 0.5 - lens.cx) / lens.fx);
    return static_cast<std::size_t>((std::atan((column - lens.cx) / lens.fx) - left) /
                                    ((right - left) / kSectors));
  }

  dsp::Pinhole lens;
  stof::test::GuardedPart<SectorFinder> in_memory;
  SectorFinder& finder = *in_memory;
  std::vector<dsp::QuarterMm> depth;
  std::vector<dsp::QuarterMm> width;
};

TEST(Sectors, AreUnknownWithoutDepth) {
  World world;
  const Sectors& found = world.find();
  for (const std::uint16_t distance : found.report.distances_cm) {
    EXPECT_EQ(distance, kUnknownSector);
  }
  EXPECT_EQ(found.ahead_cm, kUnknownSector);
}

TEST(Sectors, TellTheirDirections) {
  World world;
  const wire::SectorReport& report = world.find().report;
  const double left = std::atan(-320.5 / 500) * kRadian;
  const double right = std::atan(319.5 / 500) * kRadian;
  EXPECT_NEAR(report.step_udeg * 1e-6, (right - left) / 72, 1e-6);
  EXPECT_NEAR(report.first_udeg * 1e-6, left + (right - left) / 144, 1e-6);
  EXPECT_EQ(report.least_cm, 10);
  EXPECT_EQ(report.most_cm, 1600);
  EXPECT_NEAR(world.finder.vertical_field_rad(), std::atan(240.5 / 500) + std::atan(239.5 / 500),
              1e-6);
}

// A wall straight across at Z = 2.1 m, known to 0.2 m: its near bound is 2 m.
TEST(Sectors, MeasureAWallAlongEachDirection) {
  World world;
  world.fill(8400, 800);
  const Sectors& found = world.find();
  EXPECT_EQ(found.ahead_cm, 200);
  EXPECT_EQ(found.ahead_sigma_mm, 50U);  // a quarter of the interval
  for (int x = 0; x < 640; ++x) {
    // The nearest column of the sector decides.
    const double side = (x - 320.0) / 500;
    EXPECT_LE(found.report.distances_cm[world.sector_of(x)], 200 * std::sqrt(1 + side * side));
  }
  EXPECT_EQ(found.report.distances_cm[0],
            static_cast<int>(200 * std::sqrt(1 + 311.0 * 311 / 250'000)));
}

TEST(Sectors, GoByTheNearBound) {
  World world;
  world.paint(320, 240, 1, 1, 8000, 0);
  EXPECT_EQ(world.find().ahead_cm, 200);
  world.paint(320, 240, 1, 1, 8000, 1);  // half a quarter millimetre is rounded towards the camera
  EXPECT_EQ(world.find().ahead_cm, 199);
  world.paint(320, 240, 1, 1, 8000, 8000);
  EXPECT_EQ(world.find().ahead_cm, 100);
  world.paint(320, 240, 1, 1, 8000, 65'535);  // from behind the camera
  EXPECT_EQ(world.find().ahead_cm, 10);       // told at the least distance
}

TEST(Sectors, AskForSoManyPixels) {
  World world(kLens, {.obstacle = {}, .most_mm = 16'000});
  world.paint(322, 240, 1, 7, 4000, 0);
  EXPECT_EQ(world.find().ahead_cm, kUnknownSector);  // never free
  world.paint(322, 247, 1, 1, 12'000, 0);
  EXPECT_EQ(world.find().ahead_cm, 300);
  world.paint(323, 240, 1, 1, 4000, 0);
  EXPECT_EQ(world.find().ahead_cm, 100);
}

TEST(Sectors, LookOnlyAtTheBandOfHeights) {
  World world(kLens, {.obstacle = {.above_mm = 400, .below_mm = 200, .pixels = 1, .least_mm = 100},
                      .most_mm = 16'000});
  // At 2 m a row is 4 mm high: 400 mm above are 100 rows, 200 mm below are 50.
  world.paint(320, 240 - 101, 1, 1, 8000, 0);
  world.paint(320, 240 + 51, 1, 1, 8000, 0);
  EXPECT_EQ(world.find().ahead_cm, kUnknownSector);
  world.paint(320, 240 + 50, 1, 1, 8000, 0);
  EXPECT_EQ(world.find().ahead_cm, 200);
  world.paint(320, 240 + 50, 1, 1, 0, 0);
  world.paint(320, 240 - 100, 1, 1, 8000, 0);
  EXPECT_EQ(world.find().ahead_cm, 200);
  world.finder.set({.obstacle = {.above_mm = 0, .below_mm = 0, .pixels = 1, .least_mm = 100},
                    .most_mm = 16'000});
  EXPECT_EQ(world.find().ahead_cm, kUnknownSector);
  world.paint(320, 240, 1, 1, 8000, 0);  // the row of the horizon itself
  EXPECT_EQ(world.find().ahead_cm, 200);
}

TEST(Sectors, KnowNothingBeyondTheMost) {
  World world;
  SectorParams params = kAll;
  params.most_mm = 2000;
  world.finder.set(params);
  world.paint(320, 240, 1, 1, 8039, 0);
  EXPECT_EQ(world.find().ahead_cm, 200);
  world.paint(320, 240, 1, 1, 8040, 0);
  EXPECT_EQ(world.find().ahead_cm, kUnknownSector);
  EXPECT_EQ(world.find().report.most_cm, 200);
}

TEST(Sectors, LookAheadWithinFiveDegrees) {
  World world;
  world.paint(320 + 60, 240, 1, 1, 4000, 0);  // 6.8 degrees to the right
  EXPECT_EQ(world.find().ahead_cm, kUnknownSector);
  EXPECT_NE(world.find().report.distances_cm[world.sector_of(380)], kUnknownSector);
  world.paint(320 - 35, 240, 1, 1, 8000, 160);  // 4 degrees to the left
  world.paint(320 - 35, 241, 1, 1, 8040, 240);  // as near, but less sure
  EXPECT_EQ(world.find().ahead_cm, 198);
  EXPECT_EQ(world.find().ahead_sigma_mm, 15U);
  EXPECT_NEAR(world.finder.ahead_field_rad() * kRadian, 10, 1);
}

// By sorting, in floating point.
double reference(World& world, const SectorParams& params, std::size_t sector) {
  std::vector<double> distances;
  for (int y = 0; y < world.lens.height; ++y) {
    for (int x = 0; x < world.lens.width; ++x) {
      const int depth = world.map().depth.at(x, y);
      const int near = std::max(0, depth - (world.map().width.at(x, y) + 1) / 2);
      const double down = near * ((y - world.lens.cy) / world.lens.fy) / 4;
      if (depth > 0 && world.sector_of(x) == sector && down <= params.obstacle.below_mm &&
          -down <= params.obstacle.above_mm) {
        const double side = (x - world.lens.cx) / world.lens.fx;
        distances.push_back(near * std::sqrt(1 + side * side) / 40);
      }
    }
  }
  std::ranges::sort(distances);
  const std::size_t wanted = static_cast<std::size_t>(params.obstacle.pixels);
  return distances.size() < wanted ? -1 : distances[wanted - 1];
}

TEST(Sectors, AgreeWithASortOfAllPixels) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    Random random(seed);
    const dsp::Pinhole lens{.width = random.between(72, 160),
                            .height = random.between(1, 60),
                            .fx = random.between(60, 150) + 0.25,
                            .fy = random.between(60, 150) + 0.75,
                            .cx = random.between(30, 80) + 0.3,
                            .cy = random.between(-5, 40) + 0.7};
    const SectorParams params{.obstacle = {.above_mm = random.between(0, 1000),
                                           .below_mm = random.between(0, 1000),
                                           .pixels = random.between(1, 12),
                                           .least_mm = 0},
                              .most_mm = 16'380};
    World world(lens, params);
    for (int round = 0; round < 2; ++round) {  // nothing of the map before stays
      for (std::size_t i = 0; i < world.depth.size(); ++i) {
        world.depth[i] =
            static_cast<dsp::QuarterMm>(random.between(0, 2) * random.between(0, 15'000));
        world.width[i] = static_cast<dsp::QuarterMm>(random.between(0, 4000));
      }
      const Sectors& found = world.find();
      for (std::size_t i = 0; i < kSectors; ++i) {
        const double exact = reference(world, params, i);
        const int told = found.report.distances_cm[i];
        if (exact < 0 || exact >= 1639) {
          ASSERT_EQ(told, kUnknownSector) << "seed " << seed << " sector " << i;
        } else {
          // The tangent's table is rounded towards the camera as well.
          ASSERT_LE(told, exact) << "seed " << seed << " sector " << i;
          ASSERT_GT(told, exact - 1.2) << "seed " << seed << " sector " << i;
        }
      }
    }
  }
}

TEST(Sectors, TakePicturesOfAnySize) {
  for (const int width : {1, 2, 17, 71, 73}) {
    World world({.width = width, .height = 1, .fx = 50, .fy = 50, .cx = 0, .cy = 0});
    world.fill(4000, 0);
    EXPECT_EQ(world.find().report.distances_cm[world.sector_of(0)], 100) << width;
  }
}

}  // namespace
}  // namespace stof::firmware::test
