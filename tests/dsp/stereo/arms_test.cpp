#include "dsp/stereo/cost/arms.h"

#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded.h"
#include "tests/support/random.h"
#include "tests/support/vectors.h"

namespace stof::dsp {
namespace {

using Row = std::vector<std::uint8_t>;

TEST(Arms, ReachAsFarAsPixelsLookLikeTheirCentre) {
  const Row row{10, 10, 14, 30, 30, 30, 29, 90};
  Row left(row.size());
  Row right(row.size());
  ref::arms_along(row, {.longest = 3, .difference = 4}, left, right);
  EXPECT_EQ(left, (Row{0, 1, 2, 1, 1, 2, 3, 1}));
  EXPECT_EQ(right, (Row{2, 1, 1, 3, 2, 1, 1, 0}));
}

TEST(Arms, AcrossRowsEndWithTheImage) {
  const Row here{10, 50, 90};
  const Row above{12, 80, 91};
  const Row higher{11, 50, 10};
  Row arms(3);
  const std::array<const std::uint8_t*, 2> others{above.data(), higher.data()};
  ref::arms_across(here, others, {.longest = 5, .difference = 4}, arms);
  EXPECT_EQ(arms, (Row{2, 1, 1}));
  ref::arms_across(here, {}, {.longest = 5, .difference = 4}, arms);
  EXPECT_EQ(arms, (Row{0, 0, 0}));
}

TEST(Arms, VectorsEqualReferenceForEveryLength) {
  for (const Vectors vectors : test::all_vectors()) {
    const test::UseVectors use(vectors);
    for (std::size_t n = 0; n <= 100; ++n) {
      for (const ArmParams params : {ArmParams{1, 0}, ArmParams{5, 20}, ArmParams{12, 60},
                                     ArmParams{kMaxArm, 200}, ArmParams{kMaxArm, 255}}) {
        test::Random random(n);
        std::vector<test::GuardedBuffer<std::uint8_t>> rows;
        for (int k = 0; k <= kMaxArm; ++k) {
          random.fill(rows.emplace_back(n).span());
        }
        std::vector<test::GuardedBuffer<std::uint8_t>> out;
        for (int k = 0; k < 4; ++k) {
          out.emplace_back(n);
        }
        ref::arms_along(rows[0].span(), params, out[0].span(), out[1].span());
        best::arms_along(rows[0].span(), params, out[2].span(), out[3].span());
        ASSERT_TRUE(std::ranges::equal(out[0].span(), out[2].span()))
            << n << ", " << params.longest;
        ASSERT_TRUE(std::ranges::equal(out[1].span(), out[3].span()))
            << n << ", " << params.longest;

        std::vector<const std::uint8_t*> others;
        for (int k = 0; k < params.longest - static_cast<int>(n % 3) % params.longest; ++k) {
          others.push_back(rows[static_cast<std::size_t>(k) + 1].span().data());
        }
        ref::arms_across(rows[0].span(), others, params, out[0].span());
        best::arms_across(rows[0].span(), others, params, out[2].span());
        ASSERT_TRUE(std::ranges::equal(out[0].span(), out[2].span()))
            << n << ", " << params.longest;
      }
    }
  }
}

}  // namespace
}  // namespace stof::dsp
