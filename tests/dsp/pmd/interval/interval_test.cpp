#include "dsp/pmd/interval/interval.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/pmd/pmd_maps.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/kernel_check.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

constexpr QuarterMm kRange = 29979;
constexpr IntervalLimits kLimits{.range = kRange, .widest = kRange / 2};

struct Interval {
  int low;
  int high;
  int flags;
  friend bool operator==(const Interval&, const Interval&) = default;
};

using Block = std::array<QuarterMm, 9>;

Interval run(const Block& distance, const Block& sigma, const IntervalLimits& limits = kLimits) {
  std::uint8_t flags = 0;
  QuarterMm low = 7;
  QuarterMm high = 7;
  const std::span<const QuarterMm> d(distance);
  const std::span<const QuarterMm> s(sigma);
  best::interval({d.subspan(0, 3), d.subspan(3, 3), d.subspan(6, 3), s.subspan(0, 3),
                  s.subspan(3, 3), s.subspan(6, 3)},
                 limits, {&flags, 1}, {&low, 1}, {&high, 1});
  return {low, high, flags};
}

TEST(Interval, IsNearestAndFarthestReadingWithTwoSigmaOfEach) {
  EXPECT_EQ(run({8000, 8000, 8000, 8000, 8010, 8000, 8000, 8020, 8000},
                {10, 10, 10, 10, 10, 10, 10, 13, 9}),
            (Interval{8000 - 18, 8020 + 26, 0}));
}

TEST(Interval, LeavesOutMissingNeighbours) {
  EXPECT_EQ(run({0, 0, 0, 0, 8000, 0, 0, 0, 8004}, {0, 0, 0, 0, 10, 0, 0, 0, 10}),
            (Interval{7980, 8024, 0}));
}

TEST(Interval, OfAMissingPixelIsNone) {
  EXPECT_EQ(
      run({8000, 8000, 8000, 8000, 0, 8000, 8000, 8000, 8000}, {10, 10, 10, 10, 0, 10, 10, 10, 10}),
      (Interval{0, 0, 0}));
}

TEST(Interval, FlagsAnEdgeWhenReadingsDifferByMoreThanNoise) {
  Block distance{};
  Block sigma{};
  distance.fill(8000);
  sigma.fill(10);
  distance[2] = 8060;
  EXPECT_EQ(run(distance, sigma).flags, 0);
  distance[2] = 8061;
  EXPECT_EQ(run(distance, sigma), (Interval{7980, 8081, kPmdEdge}));
}

TEST(Interval, IsAmbiguousBeyondHalfTheUnambiguousRange) {
  Block distance{};
  Block sigma{};
  distance.fill(4000);
  distance[0] = static_cast<QuarterMm>(4000 + kRange / 2);
  EXPECT_EQ(run(distance, sigma).flags, kPmdEdge);
  ++distance[0];
  EXPECT_EQ(run(distance, sigma), (Interval{0, 0, kPmdEdge | kPmdWrapped}));
}

TEST(Interval, IsAmbiguousWhereNoiseReachesBelowZero) {
  Block distance{};
  Block sigma{};
  distance.fill(201);
  sigma.fill(100);
  EXPECT_EQ(run(distance, sigma), (Interval{1, 401, 0}));
  distance[8] = 200;  // may as well be a wall at nearly the whole range
  EXPECT_EQ(run(distance, sigma), (Interval{0, 0, kPmdWrapped}));
}

TEST(Interval, SaysWhereItReachesBeyondTheRange) {
  Block distance{};
  Block sigma{};
  distance.fill(kRange - 50);
  sigma.fill(26);
  EXPECT_EQ(run(distance, sigma), (Interval{kRange - 102, kRange + 2, kPmdOutOfRange}));
}

TEST(Interval, BelievesReadingsThatWereMovedByWholePeriods) {
  Block distance{};
  Block sigma{};
  distance.fill(kRange + 400);  // 7.59 m, read as 0.1 m
  sigma.fill(60);
  EXPECT_EQ(run(distance, sigma), (Interval{kRange + 280, kRange + 520, 0}));
  // A neighbour that nobody has moved lies right before the end of the range; it says so itself.
  distance[4] = kRange - 20;
  EXPECT_EQ(run(distance, sigma),
            (Interval{kRange - 140, kRange + 520, kPmdEdge | kPmdOutOfRange}));
  // A reading near 0 may be one behind the range: the interval does not say where.
  distance.fill(100);
  EXPECT_EQ(run(distance, sigma), (Interval{0, 0, kPmdWrapped}));
}

TEST(Interval, SaysWhereItIsMoreThanSixteenBitsHold) {
  Block distance{};
  Block sigma{};
  distance.fill(65500);
  sigma.fill(20);
  const IntervalLimits far{.range = 65535, .widest = 14990};
  EXPECT_EQ(run(distance, sigma, far), (Interval{65460, 65535, kPmdOutOfRange}));
  sigma.fill(17);
  EXPECT_EQ(run(distance, sigma, far), (Interval{65466, 65534, 0}));
}

// A frame of width x height with a border column of 0 to either side.
struct Frame {
  Frame(int w, int h, std::uint64_t seed, int spread)
      : width(w),
        height(h),
        distance(static_cast<std::size_t>((w + 2) * h)),
        sigma(static_cast<std::size_t>((w + 2) * h)) {
    test::Random random(seed);
    for (int y = 0; y < h; ++y) {
      for (int x = 1; x <= w; ++x) {
        const std::size_t i = index(x - 1, y) + 1;
        const bool missing = random.between(0, 4) == 0;
        const int d = random.between(0, 30) == 0 ? 65535 : random.between(1, spread);
        distance[i] = missing ? 0 : static_cast<QuarterMm>(d);
        const int noise = random.between(0, 40) == 0 ? 65535 : random.between(0, 60);
        sigma[i] = static_cast<QuarterMm>(missing ? 0 : noise);
      }
    }
  }
  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y * (width + 2) + x); }
  std::span<const QuarterMm> row(test::GuardedBuffer<QuarterMm>& of, int y) const {
    return of.span().subspan(index(0, std::clamp(y, 0, height - 1)),
                             static_cast<std::size_t>(width + 2));
  }
  IntervalRows rows(int y) {
    return {row(distance, y - 1), row(distance, y), row(distance, y + 1),
            row(sigma, y - 1),    row(sigma, y),    row(sigma, y + 1)};
  }
  int width;
  int height;
  test::GuardedBuffer<QuarterMm> distance;
  test::GuardedBuffer<QuarterMm> sigma;
};

TEST(Interval, ASlantedSurfaceIsNoEdgeAndAStepIs) {
  // 15 percent over two pixels is the slope; sigma 10 allows 60 more.
  const IntervalLimits slanted{.range = kRange, .widest = kRange / 2, .slope_q16 = 9830};
  const Block sigma{10, 10, 10, 10, 10, 10, 10, 10, 10};
  const Block slope{8000, 8600, 9200, 8000, 8600, 9200, 8000, 8600, 9200};
  EXPECT_EQ(run(slope, sigma, slanted).flags & kPmdEdge, 0);
  EXPECT_NE(run(slope, sigma).flags & kPmdEdge, 0);
  const Block step{8000, 8600, 9300, 8000, 8600, 9300, 8000, 8600, 9300};
  EXPECT_NE(run(step, sigma, slanted).flags & kPmdEdge, 0);
}

IntervalLimits limits_of(int width) {
  return width % 3 == 0 ? IntervalLimits{.widest = 14990,
                                         .slope_q16 = static_cast<std::uint16_t>(width * 5000)}
                        : kLimits;
}

// The contract once more, pixel by pixel on the whole frame with a clipped window.
Interval oracle(Frame& frame, const IntervalLimits& limits, int x, int y) {
  std::vector<std::pair<int, int>> readings;
  for (int v = std::max(y - 1, 0); v <= std::min(y + 1, frame.height - 1); ++v) {
    for (int u = std::max(x - 1, 0); u <= std::min(x + 1, frame.width - 1); ++u) {
      const std::size_t i = frame.index(u, v) + 1;
      if (frame.distance[i] != 0) {
        readings.emplace_back(frame.distance[i], frame.sigma[i]);
      }
    }
  }
  if (frame.distance[frame.index(x, y) + 1] == 0) {
    return {0, 0, 0};
  }
  const auto [near, far] = std::ranges::minmax(readings);
  const int lo = near.first - 2 * near.second;
  const int hi = std::min(far.first + 2 * far.second, 65535);
  int flags = 0;
  const std::int64_t slope = (std::int64_t{near.first} * limits.slope_q16) / 65536;
  if (far.first - near.first > std::min(3 * (near.second + far.second), 65535) + slope) {
    flags |= kPmdEdge;
  }
  const int here = frame.distance[frame.index(x, y) + 1];
  if ((hi > limits.range && here <= limits.range) || hi == 65535) {
    flags |= kPmdOutOfRange;
  }
  const bool wrapped = lo <= 0 || hi - lo > limits.widest;
  return wrapped ? Interval{0, 0, flags | kPmdWrapped} : Interval{lo, hi, flags};
}

TEST(Interval, EqualsTheOracleForEveryWidthAndBorder) {
  for (int width = 1; width <= 36; ++width) {
    for (const int height : {1, 2, 5}) {
      for (const int spread : {300, 20000, 65535}) {
        const std::uint64_t seed = static_cast<std::uint64_t>(width * 100 + height);
        Frame frame(width, height, seed, spread);
        const IntervalLimits limits = limits_of(width);
        for (int y = 0; y < height; ++y) {
          const std::size_t n = static_cast<std::size_t>(width);
          test::GuardedBuffer<std::uint8_t> flags(n);
          test::GuardedBuffer<QuarterMm> low(n), high(n);
          best::interval(frame.rows(y), limits, flags.span(), low.span(), high.span());
          for (std::size_t x = 0; x < n; ++x) {
            ASSERT_EQ((Interval{low[x], high[x], flags[x]}),
                      oracle(frame, limits, static_cast<int>(x), y))
                << "seed " << seed << " spread " << spread << " at " << x << "," << y;
          }
        }
      }
    }
  }
}

TEST(Interval, EqualsReferenceForEveryLength) {
  for (const int spread : {300, 20000, 65535}) {
    test::check_kernel([&](test::KernelCase& c) {
      const std::size_t n = c.length();
      Frame frame(static_cast<int>(n), 3, n, spread);
      const IntervalLimits limits = limits_of(static_cast<int>(n));
      const auto flags = c.array<std::uint8_t>(n);
      const auto low = c.array<QuarterMm>(n), high = c.array<QuarterMm>(n);
      c.run([&] { best::interval(frame.rows(1), limits, flags, low, high); });
    });
  }
}

TEST(Interval, OfAnEmptyRowTouchesNothing) {
  const std::array<QuarterMm, 2> border{};
  const std::span<const QuarterMm> b(border);
  best::interval({b, b, b, b, b, b}, kLimits, {}, {}, {});
}

TEST(Interval, KeepsTheFlagsThatAreThere) {
  test::GuardedBuffer<QuarterMm> row(19, 8000);
  const test::GuardedBuffer<QuarterMm> zero(19);
  test::GuardedBuffer<std::uint8_t> flags(17, 0x15);
  test::GuardedBuffer<QuarterMm> low(17), high(17);
  const std::span<const QuarterMm> d = row.span();
  best::interval({d, d, d, zero.span(), zero.span(), zero.span()}, kLimits, flags.span(),
                 low.span(), high.span());
  for (const std::uint8_t flag : flags.span()) {
    EXPECT_EQ(flag, 0x15);
  }
}

}  // namespace
}  // namespace stof::dsp
