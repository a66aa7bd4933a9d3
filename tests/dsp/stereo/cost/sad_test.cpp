#include "dsp/stereo/cost/sad.h"

#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded_memory.h"
#include "tests/support/kernel_check.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

template <typename Sum>
class Sad : public testing::Test {};
using Sums = testing::Types<std::uint16_t, std::uint32_t>;
TYPED_TEST_SUITE(Sad, Sums);

constexpr std::array<std::size_t, 6> kColumns{1, 2, 15, 16, 17, 33};

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

TYPED_TEST(Sad, CandidateOfAColumnIsTheReversedRightRow) {
  // n = 2 columns, 16 lanes: column 1 meets candidate i at right[i], column 0 at right[1 + i].
  std::vector<std::uint8_t> left{100, 50};
  std::vector<std::uint8_t> right(17);
  for (std::size_t m = 0; m < right.size(); ++m) {
    right[m] = static_cast<std::uint8_t>(10 * m);
  }
  std::vector<TypeParam> columns(32, 1);
  best::add_differences(left, right, 16, std::span<TypeParam>(columns));
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
  best::add_differences(first.left.span(), first.right.span(), lanes, std::span<TypeParam>(slid));
  best::add_differences(second.left.span(), second.right.span(), lanes, std::span<TypeParam>(slid));
  best::slide_differences(third.left.span(), third.right.span(), first.left.span(),
                          first.right.span(), lanes, std::span<TypeParam>(slid));
  best::add_differences(second.left.span(), second.right.span(), lanes,
                        std::span<TypeParam>(added));
  best::add_differences(third.left.span(), third.right.span(), lanes, std::span<TypeParam>(added));
  EXPECT_EQ(slid, added);
}

TYPED_TEST(Sad, AddsAndSlidesEqualReference) {
  for (const int lanes : {16, 32, 48, 64, 80, 128, 256}) {
    test::check_kernel(kColumns, [&](test::KernelCase& c) {
      const std::size_t n = c.length(), right = n + static_cast<std::size_t>(lanes) - 1;
      const auto new_left = c.array<std::uint8_t>(n, 0, 255);
      const auto new_right = c.array<std::uint8_t>(right, 0, 255);
      const auto old_left = c.array<std::uint8_t>(n, 0, 255);
      const auto old_right = c.array<std::uint8_t>(right, 0, 255);
      const auto added = c.array<TypeParam>(n * static_cast<std::size_t>(lanes), 30000, 30000);
      const auto slid = c.array<TypeParam>(n * static_cast<std::size_t>(lanes), 30000, 30000);
      c.run([&] { best::add_differences(new_left, new_right, lanes, added); });
      c.run(
          [&] { best::slide_differences(new_left, new_right, old_left, old_right, lanes, slid); });
    });
  }
}

TYPED_TEST(Sad, BlockSumsEqualReference) {
  for (const int lanes : {16, 32, 48, 64, 144}) {
    for (const int block : {1, 2, 9, 16, 63, 64}) {
      test::check_kernel(kColumns, [&](test::KernelCase& c) {
        const std::size_t n = c.length() + static_cast<std::size_t>(block) - 1;
        const auto columns = c.array<TypeParam>(n * static_cast<std::size_t>(lanes), 0, 1000);
        const auto costs = c.array<TypeParam>(c.length() * static_cast<std::size_t>(lanes));
        c.run([&] { best::block_sums(columns, block, lanes, costs); });
      });
    }
  }
}

TEST(SadBounds, LargestBlockOfU16ReachesButDoesNotWrap) {
  // 16 x 16 of the largest difference: 65280, below kNoCost.
  const RowPair black(31, 16, 1, 0, 0);
  std::vector<std::uint8_t> white(31, 255);
  std::vector<std::uint16_t> columns(31 * 16, 0), costs(16 * 16, 0);
  for (int row = 0; row < 16; ++row) {
    best::add_differences(white, black.right.span(), 16, std::span<std::uint16_t>(columns));
  }
  best::block_sums(std::span<const std::uint16_t>(columns), 16, 16,
                   std::span<std::uint16_t>(costs));
  EXPECT_TRUE(std::ranges::all_of(costs, [](std::uint16_t c) { return c == 65280; }));
}

}  // namespace
}  // namespace stof::dsp
