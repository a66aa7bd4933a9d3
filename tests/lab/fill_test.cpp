#include "lab/fill.h"

#include <cstddef>
#include <string>
#include <utility>
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

struct Filled {
  std::vector<Disparity> map;
  std::vector<std::uint8_t> marks;
};

Filled fill(std::vector<Disparity> map, int width, int height, std::uint8_t mark = 0) {
  std::vector<std::uint8_t> marks(map.size(), mark);
  test::GuardedBuffer<std::byte> memory(
      bytes_taken([&](Arena& measuring) { Filler(width, height, measuring); }));
  Arena arena(memory.span());
  Filler filler(width, height, arena);
  filler.fill({map.data(), width, height}, {marks.data(), width, height});
  return {std::move(map), std::move(marks)};
}

TEST(Fill, TakesTheLargerOfTwoNeighboursAndMarksIt) {
  const Filled filled = fill(picture("..7..3.5.."), 10, 1);
  EXPECT_EQ(filled.map, picture("7777735555"));
  EXPECT_EQ(filled.marks, (std::vector<std::uint8_t>{1, 1, 0, 1, 1, 0, 1, 0, 1, 1}));
}

TEST(Fill, TakesTheThirdFarthestOfEightDirections) {
  // Around the centre: 1 2 3 / 4 . 5 / 6 7 8.
  EXPECT_EQ(fill(picture("1234.5678"), 3, 3).map[4], Disparity::from_pixels(3));
  // Further away in the same directions, with holes between.
  const Filled far = fill(picture("9.8.7.....6...5.....4.3.2"), 5, 5);
  EXPECT_EQ(far.map[12], Disparity::from_pixels(4));
}

TEST(Fill, LooksAtWhatWasMatchedAlone) {
  const Filled filled = fill(picture("5.....3"), 7, 1);
  EXPECT_EQ(filled.map, picture("5555553"));
}

TEST(Fill, AMapWithoutAnyStaysEmptyAndUnmarked) {
  const Filled filled = fill(picture("........"), 4, 2, 7);
  EXPECT_EQ(filled.map, picture("........"));
  EXPECT_EQ(filled.marks, std::vector<std::uint8_t>(8, 7));
}

TEST(Fill, ARowWithoutAnyTakesThoseAboveAndBelow) {
  // Six directions in its middle, four at its ends.
  const Filled filled = fill(picture("222...444"), 3, 3);
  EXPECT_EQ(filled.map, picture("222424444"));
}

TEST(Fill, NegativeDisparitiesAreFarther) {
  std::vector<Disparity> map(9, Disparity::from_pixels(2));
  map[0] = map[1] = map[2] = Disparity::from_pixels(-3);
  map[4] = Disparity::none();
  EXPECT_EQ(fill(map, 3, 3).map[4], Disparity::from_pixels(-3));
}

TEST(Fill, SmallerMapsThanItHasRoomForAndTheirPaddingStay) {
  test::GuardedImage<Disparity> image(5, 3, 7, Disparity::none());
  test::GuardedImage<std::uint8_t> filled(5, 3, 6, 9);
  image.view().at(4, 1) = Disparity::from_pixels(1);
  test::GuardedBuffer<std::byte> memory(
      bytes_taken([](Arena& measuring) { Filler(8, 8, measuring); }));
  Arena arena(memory.span());
  Filler(8, 8, arena).fill(image.view(), filled.view());
  EXPECT_EQ(image.view().at(0, 1), Disparity::from_pixels(1));
  EXPECT_EQ(image.view().at(2, 2), Disparity::none());  // in none of its eight directions
  EXPECT_TRUE(image.padding_is(Disparity::none()) && filled.padding_is(9));
}

}  // namespace
}  // namespace stof::lab
