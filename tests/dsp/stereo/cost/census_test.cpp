#include "dsp/stereo/cost/census.h"

#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/kernel_check.h"

namespace stof::dsp {
namespace {

template <std::size_t kRows>
using Window = std::array<std::span<const std::uint8_t>, kRows>;

// Bit b of column x.
int bit_of(std::span<const std::uint8_t> planes, std::size_t n, std::size_t x, std::size_t bit) {
  return (planes[bit / kPlaneBits * n + x] >> (bit % kPlaneBits)) & 1;
}

TEST(Census, NumbersNeighboursAlongTheRowsAndLeavesOutTheCentre) {
  // One dark neighbour at a time, around a centre of 100.
  for (std::size_t dark = 0; dark < 63; ++dark) {
    std::array<std::array<std::uint8_t, 9>, 7> picture;
    for (auto& row : picture) {
      row.fill(100);
    }
    picture[dark / 9][dark % 9] = 99;
    Window<7> rows;
    for (std::size_t r = 0; r < 7; ++r) {
      rows[r] = picture[r];
    }
    std::vector<std::uint8_t> planes(planes_of(kCensus9x7.bits()) * 9);
    best::census_9x7(rows, planes);
    for (std::size_t bit = 0; bit < 62; ++bit) {
      const std::size_t expected = dark < 31 ? dark : dark - 1;
      // A dark centre is darker than nothing around it.
      EXPECT_EQ(bit_of(planes, 9, 4, bit), dark != 31 && bit == expected ? 1 : 0) << dark;
    }
  }
}

TEST(Census, OfSevenBySevenLooksAtTheOddFieldsOfItsWindow) {
  for (std::size_t dark = 0; dark < 49; ++dark) {
    std::array<std::array<std::uint8_t, 7>, 7> picture;
    for (auto& row : picture) {
      row.fill(100);
    }
    picture[dark / 7][dark % 7] = 99;
    Window<7> rows;
    for (std::size_t r = 0; r < 7; ++r) {
      rows[r] = picture[r];
    }
    std::vector<std::uint8_t> planes(planes_of(kCensus7x7.bits()) * 7);
    best::census_7x7(rows, planes);
    for (std::size_t bit = 0; bit < 24; ++bit) {
      EXPECT_EQ(bit_of(planes, 7, 3, bit), dark % 2 == 1 && bit == dark / 2 ? 1 : 0) << dark;
    }
  }
}

TEST(Census, OfARampIsTheDarkerSideAndRepeatsItsBorders) {
  std::array<std::uint8_t, 20> ramp;
  for (std::size_t x = 0; x < ramp.size(); ++x) {
    ramp[x] = static_cast<std::uint8_t>(10 * x);
  }
  const Window<5> rows{ramp, ramp, ramp, ramp, ramp};
  std::vector<std::uint8_t> planes(planes_of(kCensus5x5.bits()) * ramp.size());
  best::census_5x5(rows, planes);
  for (const std::size_t x : {0U, 1U, 2U, 10U, 19U}) {
    const std::size_t darker_columns = std::min<std::size_t>(x, 1);  // of the two to the left
    std::size_t ones = 0;
    for (std::size_t bit = 0; bit < 24; ++bit) {
      ones += static_cast<std::size_t>(bit_of(planes, ramp.size(), x, bit));
    }
    // At column 0 both left neighbours repeat the centre; at column 1 they are column 0.
    EXPECT_EQ(ones, 2 * 5 * darker_columns) << "column " << x;
  }
  EXPECT_EQ(bit_of(planes, ramp.size(), 10, 0), 1);   // top left
  EXPECT_EQ(bit_of(planes, ramp.size(), 10, 4), 0);   // top right
  EXPECT_EQ(bit_of(planes, ramp.size(), 10, 11), 1);  // left of the centre
  EXPECT_EQ(bit_of(planes, ramp.size(), 10, 12), 0);  // right of it
}

TEST(Census, SeesOrderAloneAcrossTheWholeRangeOfGreyValues) {
  const std::array<std::uint8_t, 6> steps{0, 127, 128, 255, 128, 0};
  const Window<5> rows{steps, steps, steps, steps, steps};
  std::vector<std::uint8_t> planes(planes_of(kCensus5x5.bits()) * 6);
  best::census_5x5(rows, planes);
  EXPECT_EQ(bit_of(planes, 6, 2, 11), 1);  // 127 < 128
  EXPECT_EQ(bit_of(planes, 6, 2, 12), 0);  // 255 > 128
  EXPECT_EQ(bit_of(planes, 6, 3, 11), 1);  // 128 < 255
  EXPECT_EQ(bit_of(planes, 6, 4, 12), 1);  // 0 < 128
  EXPECT_EQ(bit_of(planes, 6, 4, 10), 0);  // 128 is not darker than 128
}

template <std::size_t kRows, typename Best>
void expect_equals_reference(int bits, const Best& census) {
  test::check_kernel([&](test::KernelCase& c) {
    Window<kRows> rows;
    for (std::span<const std::uint8_t>& row : rows) {
      // Few grey levels: many neighbours equal their centre.
      const bool few = c.length() % 2 != 0;
      row = c.array<std::uint8_t>(c.length(), few ? 126 : 0, few ? 130 : 255);
    }
    const auto planes = c.array<std::uint8_t>(planes_of(bits) * c.length());
    c.run([&] { census(rows, planes); });
  });
}

TEST(Census, EqualsReferenceForEveryLength) {
  expect_equals_reference<5>(kCensus5x5.bits(), best::census_5x5);
  expect_equals_reference<7>(kCensus7x7.bits(), best::census_7x7);
  expect_equals_reference<7>(kCensus9x7.bits(), best::census_9x7);
}

}  // namespace
}  // namespace stof::dsp
