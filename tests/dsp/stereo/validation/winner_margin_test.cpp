#include "dsp/stereo/validation/winner_margin.h"

#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded_memory.h"
#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

constexpr std::array<std::size_t, 9> kPixels{0, 1, 2, 7, 8, 9, 16, 17, 33};

template <typename Sum>
class Distinct : public testing::Test {};
using Sums = testing::Types<std::uint8_t, std::uint16_t, std::uint32_t>;
TYPED_TEST_SUITE(Distinct, Sums);

TYPED_TEST(Distinct, ComparesTheWinnerWithSeventyPercentOfTheMean) {
  // Three candidates of 100, 30 and 200: mean 110, 70 percent of it 77.
  std::vector<TypeParam> costs(16, kNoCost<TypeParam>);
  costs[0] = 100;
  costs[1] = 30;
  costs[2] = 200;
  std::vector<std::int16_t> margins(1);
  const auto margin = [&](std::int16_t winner, int shift) {
    best::winner_margins(std::span<const TypeParam>(costs), 16, std::vector{winner}, 70, shift,
                         margins);
    return margins[0];
  };
  EXPECT_EQ(margin(1, 0), 70 * 330 - 100 * 3 * 30);
  EXPECT_EQ(margin(0, 0), 70 * 330 - 100 * 3 * 100);
  EXPECT_EQ(margin(0, 4), -432);  // floor of -431.25
  EXPECT_EQ(margin(kNoWinner, 0), 0);
  EXPECT_EQ(margin(3, 0), 0);  // has no cost
  costs[1] = 77;
  costs[2] = 153;
  EXPECT_EQ(margin(1, 0), 0);  // exactly 70 percent
}

TYPED_TEST(Distinct, TheShiftKeepsTheLargestMarginWhole) {
  const int cost = sizeof(TypeParam) == 1 ? 254 : 7680;
  std::vector<TypeParam> costs(64, static_cast<TypeParam>(cost));
  costs[9] = 0;
  std::vector<std::int16_t> margins(1);
  const int shift = margin_shift(cost, 64);
  best::winner_margins(std::span<const TypeParam>(costs), 64, std::vector<std::int16_t>{9}, 70,
                       shift, margins);
  EXPECT_LT(margins[0], 32767);
  EXPECT_EQ(margins[0], (70 * 63 * cost) >> shift);
}

TYPED_TEST(Distinct, EqualsReferenceForEveryLengthAndShift) {
  for (const int lanes : {16, 64, 256}) {
    for (const int spread : {0, 30, 65534, 260000000}) {
      const int largest =
          static_cast<int>(std::min<std::int64_t>(spread, std::int64_t{kNoCost<TypeParam>} - 1));
      for (const int shift : {0, 3, margin_shift(largest, lanes)}) {
        test::check_kernel(kPixels, [&](test::KernelCase& c) {
          const std::size_t n = c.length();
          const auto costs = c.array<TypeParam>(n * static_cast<std::size_t>(lanes), 0, largest);
          for (TypeParam& cost : costs) {
            cost = c.random().between(0, 7) == 0 ? kNoCost<TypeParam> : cost;
          }
          const auto winners = c.array<std::int16_t>(n, kNoWinner, lanes - 1);
          const auto margins = c.array<std::int16_t>(n);
          const int percent = lanes % 3 == 0 ? 70 : 85;
          c.run([&] { best::winner_margins(costs, lanes, winners, percent, shift, margins); });
        });
      }
    }
  }
}

TEST(DropSmallMargins, SurroundingsDecideForEverySplit) {
  const int width = 70, height = 40;
  test::GuardedImage<std::int16_t> margins(width, height, width + 1, 10);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width / 2; ++x) {
      margins.view().at(x, y) = -10;
    }
  }
  std::vector<std::vector<Disparity>> results;
  for (const auto& parts :
       {std::vector<Rows>{{0, height}}, std::vector<Rows>{{7, height}, {0, 7}}}) {
    std::vector<Disparity> out(static_cast<std::size_t>(width * height), Disparity::from_pixels(1));
    test::GuardedBuffer<std::byte> memory(
        bytes_taken([&](Arena& measuring) { WindowSums(width, measuring); }));
    Arena arena(memory.span());
    WindowSums window(width, arena);
    for (const Rows part : parts) {
      drop_small_margins(margins.view(), part, window, {out.data(), width, height});
    }
    results.push_back(out);
  }
  EXPECT_EQ(results[0], results[1]);
  for (int x = 0; x < width; ++x) {
    // Columns x - 12 .. x + 11: at 35 both kinds are twelve each, and 0 is not enough.
    EXPECT_EQ(results[0][static_cast<std::size_t>(x)].valid(), x > 35) << x;
  }
}

}  // namespace
}  // namespace stof::dsp
