#include "dsp/stereo/cost/sad.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

template <typename Sum>
class Sad : public testing::Test {};
using Sums = testing::Types<std::uint16_t, std::uint32_t>;
TYPED_TEST_SUITE(Sad, Sums);

struct RowPair {
  test::GuardedBuffer<std::uint8_t> left;
  test::GuardedBuffer<std::uint8_t> right;
  RowPair(std::size_t n, int lanes, std::uint64_t seed, int low = 0, int high = 255)
      : left(n), right(n + static_cast<std::size_t>(lanes) - 1) {
    test::Random random(seed);
    random.fill(left.span(), low, high);
    random.fill(right.span(), low, high);
  }
};

template <typename Sum>
void expect_equal(const test::GuardedBuffer<Sum>& a, const test::GuardedBuffer<Sum>& b,
                  std::size_t n, int lanes) {
  ASSERT_TRUE(std::ranges::equal(a.span(), b.span())) << "columns " << n << " lanes " << lanes;
}

TYPED_TEST(Sad, CandidateOfAColumnIsTheReversedRightRow) {
  // n = 2 columns, 16 lanes: column 1 meets candidate i at right[i], column 0 at right[1 + i].
  std::vector<std::uint8_t> left{100, 50};
  std::vector<std::uint8_t> right(17);
  for (std::size_t m = 0; m < right.size(); ++m) {
    right[m] = static_cast<std::uint8_t>(10 * m);
  }
  std::vector<TypeParam> columns(32, 1);
  ref::add_differences(left, right, 16, std::span<TypeParam>(columns));
  EXPECT_EQ(columns[0], 1 + 90);         // |100 - right[1]|
  EXPECT_EQ(columns[9], 1 + 0);          // |100 - right[10]|
  EXPECT_EQ(columns[16], 1 + 50);        // |50 - right[0]|
  EXPECT_EQ(columns[16 + 15], 1 + 100);  // |50 - right[15]|
}

TYPED_TEST(Sad, SlidingEqualsAddingTheRowsThatStay) {
  const std::size_t n = 37;
  const int lanes = 48;
  const RowPair first(n, lanes, 1), second(n, lanes, 2), third(n, lanes, 3);
  std::vector<TypeParam> slid(n * 48, 0), added(n * 48, 0);
  ref::add_differences(first.left.span(), first.right.span(), lanes, std::span<TypeParam>(slid));
  ref::add_differences(second.left.span(), second.right.span(), lanes, std::span<TypeParam>(slid));
  ref::slide_differences(third.left.span(), third.right.span(), first.left.span(),
                         first.right.span(), lanes, std::span<TypeParam>(slid));
  ref::add_differences(second.left.span(), second.right.span(), lanes, std::span<TypeParam>(added));
  ref::add_differences(third.left.span(), third.right.span(), lanes, std::span<TypeParam>(added));
  EXPECT_EQ(slid, added);
}

TYPED_TEST(Sad, NeonAddsAndSlidesAsTheReference) {
  for (const int lanes : {16, 32, 48, 64, 80, 128, 256}) {
    for (const std::size_t n : {0U, 1U, 2U, 15U, 16U, 17U, 33U}) {
      if (n == 0) {
        continue;  // a row has at least one column
      }
      const RowPair entering(n, lanes, n), leaving(n, lanes, n + 1000);
      const std::size_t count = n * static_cast<std::size_t>(lanes);
      test::GuardedBuffer<TypeParam> reference(count, 30000), neon(count, 30000);
      ref::add_differences(entering.left.span(), entering.right.span(), lanes, reference.span());
      neon::add_differences(entering.left.span(), entering.right.span(), lanes, neon.span());
      expect_equal(reference, neon, n, lanes);
      ref::slide_differences(leaving.left.span(), leaving.right.span(), entering.left.span(),
                             entering.right.span(), lanes, reference.span());
      neon::slide_differences(leaving.left.span(), leaving.right.span(), entering.left.span(),
                              entering.right.span(), lanes, neon.span());
      expect_equal(reference, neon, n, lanes);
    }
  }
}

TYPED_TEST(Sad, NeonSumsBlocksAsTheReference) {
  for (const int lanes : {16, 32, 48, 64, 144}) {
    for (const int block : {1, 2, 9, 16, 63, 64}) {
      for (const std::size_t outputs : {1U, 2U, 7U, 16U, 41U}) {
        const std::size_t n = outputs + static_cast<std::size_t>(block) - 1;
        test::GuardedBuffer<TypeParam> columns(n * static_cast<std::size_t>(lanes));
        test::Random(n).fill(columns.span(), 0, 1000);
        test::GuardedBuffer<TypeParam> reference(outputs * static_cast<std::size_t>(lanes));
        test::GuardedBuffer<TypeParam> neon(outputs * static_cast<std::size_t>(lanes));
        ref::block_sums(std::span<const TypeParam>(columns.span()), block, lanes, reference.span());
        neon::block_sums(std::span<const TypeParam>(columns.span()), block, lanes, neon.span());
        expect_equal(reference, neon, n, lanes);
      }
    }
  }
}

TEST(SadBounds, LargestBlockOfU16ReachesButDoesNotWrap) {
  // 16 x 16 of the largest difference: 65280, below kNoCost.
  const RowPair black(31, 16, 1, 0, 0);
  std::vector<std::uint8_t> white(31, 255);
  std::vector<std::uint16_t> columns(31 * 16, 0), costs(16 * 16, 0);
  for (int row = 0; row < 16; ++row) {
    neon::add_differences(white, black.right.span(), 16, std::span<std::uint16_t>(columns));
  }
  neon::block_sums(std::span<const std::uint16_t>(columns), 16, 16,
                   std::span<std::uint16_t>(costs));
  EXPECT_TRUE(std::ranges::all_of(costs, [](std::uint16_t c) { return c == 65280; }));
}

}  // namespace
}  // namespace stof::dsp
