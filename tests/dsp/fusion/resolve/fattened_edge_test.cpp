#include "dsp/fusion/resolve/fattened_edge.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace stof::dsp {
namespace {

// 200 up to column `edge`, 60 from there on.
std::vector<std::uint8_t> picture(std::size_t edge) {
  std::vector<std::uint8_t> row(100, 200);
  std::fill(row.begin() + static_cast<std::ptrdiff_t>(edge), row.end(), std::uint8_t{60});
  return row;
}

TEST(FattenedEdge, EndsAtTheEdgeOfThePicture) {
  const std::vector<std::uint8_t> row = picture(45);
  const FattenedEdge edge(row, 30, 40);
  EXPECT_EQ(edge.end(), 45U);
  EXPECT_TRUE(edge.is_behind(42));
  EXPECT_FALSE(edge.is_behind(45));
}

TEST(FattenedEdge, OfTwoEdgesTheGreaterCountsAndOfEqualOnesTheFirst) {
  std::vector<std::uint8_t> row = picture(46);
  std::fill(row.begin() + 42, row.begin() + 46, std::uint8_t{150});
  EXPECT_EQ(FattenedEdge(row, 30, 40).end(), 46U);
  std::fill(row.begin() + 42, row.begin() + 46, std::uint8_t{130});
  EXPECT_EQ(FattenedEdge(row, 30, 40).end(), 42U);
}

TEST(FattenedEdge, AMatchThatBeginsAtTheEdgeIsNotFattened) {
  const std::vector<std::uint8_t> row = picture(40);
  EXPECT_EQ(FattenedEdge(row, 30, 40).end(), 40U);
}

TEST(FattenedEdge, LooksNoFartherThanItsBand) {
  EXPECT_EQ(FattenedEdge(picture(48), 30, 40).end(), 48U);
  EXPECT_EQ(FattenedEdge(picture(49), 30, 40).end(), 40U);
}

TEST(FattenedEdge, AWeakEdgeIsNone) {
  std::vector<std::uint8_t> row(100, 100);
  std::fill(row.begin() + 45, row.end(), std::uint8_t{100 + kEdgeStep - 1});
  EXPECT_EQ(FattenedEdge(row, 30, 40).end(), 40U);
  std::fill(row.begin() + 45, row.end(), std::uint8_t{100 + kEdgeStep});
  EXPECT_EQ(FattenedEdge(row, 30, 40).end(), 45U);
}

TEST(FattenedEdge, WhatLooksLikeNeitherIsNotBehind) {
  std::vector<std::uint8_t> row = picture(45);
  row[42] = 130;
  row[43] = 161;
  row[44] = 155;
  const FattenedEdge edge(row, 30, 40);
  EXPECT_FALSE(edge.is_behind(42));
  EXPECT_TRUE(edge.is_behind(43));   // 39 from the one, 101 from the other
  EXPECT_FALSE(edge.is_behind(44));  // 45, 95
}

TEST(FattenedEdge, AtTheBordersOfThePictureNothingIsSaid) {
  const std::vector<std::uint8_t> row = picture(6);
  EXPECT_EQ(FattenedEdge(row, 1, 3).end(), 3U);
  EXPECT_EQ(FattenedEdge(row, 2, 3).end(), 6U);
  EXPECT_EQ(FattenedEdge(picture(93), 60, 89).end(), 93U);
  EXPECT_EQ(FattenedEdge(picture(93), 60, 90).end(), 90U);
}

}  // namespace
}  // namespace stof::dsp
