#include "dsp/fusion/project/cover.h"

#include <algorithm>
#include <array>

#include <gtest/gtest.h>

#include "tests/support/guarded.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

struct Halves {
  std::int32_t x = 0;
  std::int32_t y = 0;
  friend bool operator==(const Halves&, const Halves&) = default;
};
Halves half_of(QuarterMm distance, std::int16_t forward, QuarterMm depth, const CoverScale& scale) {
  Halves half;
  ref::half_sizes({&distance, 1}, {&forward, 1}, {&depth, 1}, scale, {&half.x, 1}, {&half.y, 1});
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
  constexpr Halves kNone{kCoversNothing, kCoversNothing};
  EXPECT_EQ(half_of(0, 32767, 8000, {1, 1}), kNone);
  EXPECT_EQ(half_of(8000, 32767, 0, {1, 1}), kNone);
  EXPECT_EQ(half_of(8000, 0, 8000, {1, 1}), kNone);
  EXPECT_EQ(half_of(8000, -32767, 8000, {1, 1}), kNone);
}

TEST(HalfSizes, NeonEqualsReferenceForEveryLengthAndExtreme) {
  for (std::size_t n = 0; n <= 40; ++n) {
    for (int variant = 0; variant < 4; ++variant) {
      test::Random random(n * 4 + static_cast<std::size_t>(variant));
      test::GuardedBuffer<QuarterMm> distance(n), depth(n);
      test::GuardedBuffer<std::int16_t> forward(n);
      test::GuardedBuffer<std::int32_t> x_a(n), y_a(n), x_b(n), y_b(n);
      random.fill(distance.span(), 0, variant == 0 ? 2 : 65535);
      random.fill(depth.span(), 0, variant == 1 ? 2 : 65535);
      random.fill(forward.span(), variant == 2 ? -3 : 0, variant == 2 ? 3 : 32767);
      const CoverScale scale{static_cast<float>(random.between(1, 100000)) / 1e6F,
                             static_cast<float>(random.between(1, 100000)) / 1e3F};
      ref::half_sizes(distance.span(), forward.span(), depth.span(), scale, x_a.span(), y_a.span());
      neon::half_sizes(distance.span(), forward.span(), depth.span(), scale, x_b.span(),
                       y_b.span());
      ASSERT_TRUE(std::ranges::equal(x_a.span(), x_b.span())) << n << "/" << variant;
      ASSERT_TRUE(std::ranges::equal(y_a.span(), y_b.span())) << n << "/" << variant;
    }
  }
}

TEST(Cover, TakesThePixelsWhoseCentresLieWithin) {
  for (const int half : {0, 8, 9, 16, 40, 1000}) {
    for (int place = -200; place <= 400; ++place) {
      const PixelRange range = covered(place, half, 12);
      for (int x = 0; x < 12; ++x) {
        ASSERT_EQ(std::abs(16 * x - place) <= half, range.begin <= x && x < range.end)
            << x << " of " << place << " +- " << half;
      }
    }
  }
}

TEST(Cover, TakesNothingWhereThereIsNoReading) {
  for (int place = -40; place <= 400; ++place) {
    const PixelRange range = covered(place, kCoversNothing, 12);
    ASSERT_GE(range.begin, range.end) << place;
  }
}

TEST(Cover, NeonEqualsReferenceForEveryLengthAndExtreme) {
  for (std::size_t n = 0; n <= 40; ++n) {
    for (const int size : {0, 1, 640, 32767}) {
      test::Random random(n + static_cast<std::size_t>(size));
      test::GuardedBuffer<std::int32_t> place(n), half(n);
      test::GuardedBuffer<std::int16_t> begin_a(n), end_a(n), begin_b(n), end_b(n);
      const int far = random.between(0, 1) == 0 ? kFarthestPosition : 16 * size;
      random.fill(place.span(), -far, far);
      random.fill(half.span(), kCoversNothing, random.between(0, 1) == 0 ? kFarthestPosition : 99);
      ref::cover(place.span(), half.span(), size, begin_a.span(), end_a.span());
      neon::cover(place.span(), half.span(), size, begin_b.span(), end_b.span());
      ASSERT_TRUE(std::ranges::equal(begin_a.span(), begin_b.span())) << n << "/" << size;
      ASSERT_TRUE(std::ranges::equal(end_a.span(), end_b.span())) << n << "/" << size;
    }
  }
}

}  // namespace
}  // namespace stof::dsp
