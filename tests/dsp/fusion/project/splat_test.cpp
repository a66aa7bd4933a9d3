#include "dsp/fusion/project/splat.h"

#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/kernel_check.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

TEST(VisibleBehind, IsTwoPercentAndNeverHidesASurfaceFromItself) {
  for (std::uint32_t depth = 1; depth <= 65535; ++depth) {
    const std::uint32_t nearest = visible_behind(static_cast<QuarterMm>(depth));
    ASSERT_LE(nearest, depth);
    ASSERT_LE(50 * depth, 51 * nearest) << depth;        // within 2 percent
    ASSERT_GT(50 * depth, 51 * (nearest - 1)) << depth;  // one less is not
  }
}

TEST(Splat, UnitesWithinTwoPercentAndHidesWhatIsFarther) {
  std::array<QuarterMm, 3> nearest{1000, 981, 980};
  std::array<QuarterMm, 3> low{950, 950, 950};
  std::array<QuarterMm, 3> high{1050, 1050, 1050};
  std::array<std::uint8_t, 3> flags{1, 1, 1};
  best::splat_interval({visible_behind(1000), 900, 1100, 32}, nearest, low, high, flags);
  EXPECT_EQ(low, (std::array<QuarterMm, 3>{900, 900, 950}));
  EXPECT_EQ(high, (std::array<QuarterMm, 3>{1100, 1100, 1050}));
  EXPECT_EQ(flags, (std::array<std::uint8_t, 3>{33, 33, 1}));
}

TEST(Splat, StaysInTheFootprintAndInTheRows) {
  std::array<QuarterMm, 12> nearest{};
  nearest.fill(985);
  const Footprint footprint{1, 3, 0, 2, 980, {visible_behind(980), 900, 1100, 32}};
  const ImageView<QuarterMm> image(nearest.data(), 4, 3);
  best::splat_nearest({&footprint, 1}, {1, 3}, image);
  EXPECT_EQ(nearest, (std::array<QuarterMm, 12>{985, 985, 985, 985, 985, 980, 980, 985, 985, 985,
                                                985, 985}));
  std::array<QuarterMm, 12> low{};
  low.fill(kNoSplat);
  std::array<QuarterMm, 12> high{};
  std::array<std::uint8_t, 12> flags{};
  best::splat_intervals({&footprint, 1}, {1, 3},
                        {image, {low.data(), 4, 3}, {high.data(), 4, 3}, {flags.data(), 4, 3}});
  EXPECT_EQ(high, (std::array<QuarterMm, 12>{0, 0, 0, 0, 0, 1100, 1100, 0, 0, 0, 0, 0}));
  EXPECT_EQ(flags, (std::array<std::uint8_t, 12>{0, 0, 0, 0, 0, 32, 32, 0, 0, 0, 0, 0}));
  EXPECT_EQ(low[5], 900);
  EXPECT_EQ(low[4], kNoSplat);
}

std::vector<Footprint> footprints_in(int width, int height, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Footprint> footprints;
  for (int k = random.between(0, 6); k > 0; --k) {
    const int x = random.between(0, width - 1);
    const int y = random.between(0, height - 1);
    const int x_end = random.between(0, 3) == 0 ? width : random.between(x + 1, width);
    const auto depth = static_cast<QuarterMm>(random.next());
    footprints.push_back({.x_begin = static_cast<std::int16_t>(x),
                          .x_end = static_cast<std::int16_t>(x_end),
                          .y_begin = static_cast<std::int16_t>(y),
                          .y_end = static_cast<std::int16_t>(random.between(y + 1, height)),
                          .depth = depth,
                          .value = {.visible = visible_behind(depth),
                                    .low = static_cast<QuarterMm>(random.next()),
                                    .high = static_cast<QuarterMm>(random.next()),
                                    .flags = static_cast<std::uint8_t>(random.next())}});
  }
  return footprints;
}

TEST(Splat, EqualsReferenceForFootprintsOfEverySize) {
  test::check_kernel_rounds(800, [](test::KernelCase& c) {
    const int width = static_cast<int>(c.length() / 20) + 1;
    const int height = c.random().between(1, 9);
    const std::vector<Footprint> footprints = footprints_in(width, height, c.length());
    const Rows rows{c.random().between(0, height - 1), height - c.random().between(0, height) / 2};
    const SplattedView view{c.image<QuarterMm>(width, height), c.image<QuarterMm>(width, height),
                            c.image<QuarterMm>(width, height),
                            c.image<std::uint8_t>(width, height)};
    for (int y = 0; y < height; ++y) {
      for (QuarterMm& depth : view.nearest.row(y)) {
        depth = c.random().between(0, 4) == 0 ? kNoSplat : depth;
      }
    }
    c.run([&] { best::splat_intervals(footprints, rows, view); });
    c.run([&] { best::splat_nearest(footprints, rows, view.nearest); });
  });
}

TEST(Splat, EqualsReferenceForSegmentsOfEveryLength) {
  for (const QuarterMm depth : {QuarterMm{0}, QuarterMm{30000}, kMaxQuarterMm}) {
    test::check_kernel([&](test::KernelCase& c) {
      const std::size_t n = c.length();
      const auto nearest = c.array<QuarterMm>(n);
      for (QuarterMm& at : nearest) {
        at = c.random().between(0, 4) == 0 ? kNoSplat : at;
      }
      const auto low = c.array<QuarterMm>(n, 0, 65535), high = c.array<QuarterMm>(n, 0, 65535);
      const auto flags = c.array<std::uint8_t>(n);
      const FootprintValue value{depth, static_cast<QuarterMm>(c.draw(0, 65535)),
                                 static_cast<QuarterMm>(c.draw(0, 65535)),
                                 static_cast<std::uint8_t>(c.draw(0, 255))};
      c.run([&] { best::splat_interval(value, nearest, low, high, flags); });
    });
  }
}

}  // namespace
}  // namespace stof::dsp
