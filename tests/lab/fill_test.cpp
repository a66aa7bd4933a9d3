#include "lab/fill.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded_memory.h"

namespace stof::lab {
namespace {

// '.' is none, a digit a whole disparity.
std::vector<Disparity> picture(const std::string& text) {
  std::vector<Disparity> out;
  for (const char c : text) {
    out.push_back(c == '.' ? Disparity::none() : Disparity::from_pixels(c - '0'));
  }
  return out;
}

TEST(Fill, TakesTheFartherNeighbourAndMarksIt) {
  auto row = picture("..7..3.5..");
  std::vector<std::uint8_t> filled(10);
  fill_from_background({row.data(), 10, 1}, {0, 1}, {filled.data(), 10, 1});
  EXPECT_EQ(row, picture("7773333555"));
  EXPECT_EQ(filled, (std::vector<std::uint8_t>{1, 1, 0, 1, 1, 0, 1, 0, 1, 1}));
}

TEST(Fill, ARowWithoutAnyStaysEmpty) {
  auto rows = picture("....12.1");
  std::vector<std::uint8_t> filled{0, 0, 7, 0, 0, 0, 0, 0};
  fill_from_background({rows.data(), 4, 2}, {0, 2}, {filled.data(), 4, 2});
  EXPECT_EQ(rows, picture("....1211"));
  EXPECT_EQ(filled, (std::vector<std::uint8_t>{0, 0, 7, 0, 0, 0, 1, 0}));
}

TEST(Fill, NegativeDisparitiesAreFarther) {
  std::vector<Disparity> row{Disparity::from_pixels(-3), {}, Disparity::from_pixels(2)};
  std::vector<std::uint8_t> filled(3);
  fill_from_background({row.data(), 3, 1}, {0, 1}, {filled.data(), 3, 1});
  EXPECT_EQ(row[1], Disparity::from_pixels(-3));
}

TEST(Fill, WritesItsRowsOnly) {
  test::GuardedImage<Disparity> image(5, 3, 7, Disparity::none());
  test::GuardedImage<std::uint8_t> filled(5, 3, 6, 9);
  image.view().at(4, 1) = Disparity::from_pixels(1);
  image.view().at(4, 2) = Disparity::from_pixels(1);
  fill_from_background(image.view(), {1, 2}, filled.view());
  EXPECT_TRUE(image.view().at(0, 1).valid());
  EXPECT_FALSE(image.view().at(0, 2).valid());
  EXPECT_EQ(filled.view().at(0, 2), 9);
  EXPECT_TRUE(image.padding_is(Disparity::none()) && filled.padding_is(9));
}

}  // namespace
}  // namespace stof::lab
