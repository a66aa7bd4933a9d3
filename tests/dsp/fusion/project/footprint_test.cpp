#include "dsp/fusion/project/footprint.h"

#include <gtest/gtest.h>

#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

struct Halves {
  std::int32_t x = 0;
  std::int32_t y = 0;
  friend bool operator==(const Halves&, const Halves&) = default;
};
Halves half_of(QuarterMm distance, std::int16_t forward, QuarterMm depth,
               const FootprintScale& scale) {
  Halves half;
  best::half_sizes({&distance, 1}, {&forward, 1}, {&depth, 1}, scale, {&half.x, 1}, {&half.y, 1});
  return half;
}

// 1483 px and 45.279 px straight ahead: 16.98 px to either side, the chapter's 33 px in all.
constexpr float kChapter = static_cast<float>(1483 / 45.279 / 2 * kPositionOne / kQ15One);

TEST(HalfSizes, AreThoseOfAPixelSeenFromTheLeftCamera) {
  EXPECT_EQ(half_of(8000, 32767, 8000, {kChapter, kChapter / 2}), (Halves{271, 140}));
  EXPECT_EQ(half_of(8000, 32767, 16000, {kChapter, kChapter}), (Halves{140, 140}));  // twice as far
  EXPECT_EQ(half_of(8000, 16384, 8000, {kChapter, kChapter}), (Halves{140, 140}));
  EXPECT_EQ(half_of(1, 1, 65535, {kChapter, kChapter}), (Halves{9, 9}));  // the margin alone
  EXPECT_EQ(half_of(65535, 32767, 1, {1, 1}), (Halves{kFarthestPosition, kFarthestPosition}));
}

TEST(HalfSizes, AreNoneWithoutAReading) {
  constexpr Halves kNone{kNoFootprint, kNoFootprint};
  EXPECT_EQ(half_of(0, 32767, 8000, {1, 1}), kNone);
  EXPECT_EQ(half_of(8000, 32767, 0, {1, 1}), kNone);
  EXPECT_EQ(half_of(8000, 0, 8000, {1, 1}), kNone);
  EXPECT_EQ(half_of(8000, -32767, 8000, {1, 1}), kNone);
}

TEST(HalfSizes, EqualReferenceForEveryLengthAndExtreme) {
  for (int variant = 0; variant < 4; ++variant) {
    test::check_kernel([&](test::KernelCase& c) {
      const std::size_t n = c.length();
      const auto distance = c.array<QuarterMm>(n, 0, variant == 0 ? 2 : 65535);
      const auto depth = c.array<QuarterMm>(n, 0, variant == 1 ? 2 : 65535);
      const auto forward =
          c.array<std::int16_t>(n, variant == 2 ? -3 : 0, variant == 2 ? 3 : 32767);
      const FootprintScale scale{static_cast<float>(c.draw(1, 100000)) / 1e6F,
                                 static_cast<float>(c.draw(1, 100000)) / 1e3F};
      const auto x = c.array<std::int32_t>(n), y = c.array<std::int32_t>(n);
      c.run([&] { best::half_sizes(distance, forward, depth, scale, x, y); });
    });
  }
}

TEST(FootprintRanges, TakesThePixelsWhoseCentresLieWithin) {
  for (const int half : {0, 8, 9, 16, 40, 1000}) {
    for (int place = -200; place <= 400; ++place) {
      const PixelRange range = footprint_range(place, half, 12);
      for (int x = 0; x < 12; ++x) {
        ASSERT_EQ(std::abs(16 * x - place) <= half, range.begin <= x && x < range.end)
            << x << " of " << place << " +- " << half;
      }
    }
  }
}

TEST(FootprintRanges, TakesNothingWhereThereIsNoReading) {
  for (int place = -40; place <= 400; ++place) {
    const PixelRange range = footprint_range(place, kNoFootprint, 12);
    ASSERT_GE(range.begin, range.end) << place;
  }
}

TEST(FootprintRanges, EqualsReferenceForEveryLengthAndExtreme) {
  for (const int size : {0, 1, 640, 32767}) {
    for (const int widest : {99, int{kFarthestPosition}}) {
      test::check_kernel([&](test::KernelCase& c) {
        const std::size_t n = c.length();
        const int far = widest == 99 ? 16 * size : int{kFarthestPosition};
        const auto place = c.array<std::int32_t>(n, -far, far);
        const auto half = c.array<std::int32_t>(n, kNoFootprint, widest);
        const auto begin = c.array<std::int16_t>(n), end = c.array<std::int16_t>(n);
        c.run([&] { best::footprint_ranges(place, half, size, begin, end); });
      });
    }
  }
}

}  // namespace
}  // namespace stof::dsp
