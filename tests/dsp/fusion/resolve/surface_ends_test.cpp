#include "dsp/fusion/resolve/surface_ends.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include <gtest/gtest.h>

namespace stof::dsp {
namespace {

constexpr int kColumns = 40;
constexpr int kRows = 32;
constexpr int kX = 20;
constexpr int kY = 16;
constexpr int kRaw = 160;
constexpr int kMost = 12;

// A surface and a picture without a step; both views have rows that are longer than them.
class Views {
 public:
  MatchedView view() { return {disparity(), picture()}; }
  ImageView<Disparity> disparity() { return {matches_.data(), kColumns, kRows, kColumns + 3}; }
  ImageView<std::uint8_t> picture() { return {greys_.data(), kColumns, kRows, kColumns + 5}; }
  int beyond(int x = kX, int y = kY) { return beyond_edge(view(), {x, y, kRaw, kMost}); }

 private:
  std::vector<Disparity> matches_ =
      std::vector<Disparity>((kColumns + 3) * kRows, Disparity::from_raw(kRaw));
  std::vector<std::uint8_t> greys_ = std::vector<std::uint8_t>((kColumns + 5) * kRows, 100);
};

TEST(Log2, IsExactAtPowersOfTwoAndStraightBetween) {
  EXPECT_EQ(log2_q4(1), 0);
  EXPECT_EQ(log2_q4(64), 6 * 16);
  EXPECT_EQ(log2_q4(96), 6 * 16 + 8);
}

TEST(BeyondEdge, NothingIsKnownWithoutAnEndOrAPicture) {
  Views views;
  std::ranges::fill(views.picture().row(kY).subspan(kX + 3), std::uint8_t{200});
  EXPECT_EQ(views.beyond(), 0);
  views.disparity().at(kX + 8, kY) = Disparity::none();
  EXPECT_NE(views.beyond(), 0);
  EXPECT_EQ(beyond_edge({views.disparity()}, {kX, kY, kRaw, kMost}), 0);
}

TEST(BeyondEdge, ASurfaceEndsWhereMatchesDifferByMoreThanItsOwn) {
  Views views;
  views.picture().at(kX + 8, kY) = 108;  // the last step that counts
  views.disparity().at(kX + 4, kY) = Disparity::from_raw(kRaw - kMost);
  EXPECT_EQ(views.beyond(), 0);
  views.disparity().at(kX + 4, kY) = Disparity::from_raw(kRaw - kMost - 1);
  EXPECT_EQ(views.beyond(), log2_q4(4) - log2_q4(12));
  views.disparity().at(kX + 4, kY) = Disparity::from_raw(kRaw + kMost + 1);
  EXPECT_EQ(views.beyond(), log2_q4(4) - log2_q4(12));
}

TEST(BeyondEdge, TheEdgeLiesBackOrOn) {
  Views views;
  views.disparity().at(kX + 4, kY) = Disparity::none();
  views.picture().at(kX - 6, kY) = 160;  // 6 px back
  EXPECT_EQ(views.beyond(), log2_q4(64) - log2_q4(4));
  views.picture().at(kX + 9, kY) = 255;  // too far on
  EXPECT_EQ(views.beyond(), log2_q4(64) - log2_q4(4));
  views.picture().at(kX + 8, kY) = 40;
  EXPECT_EQ(views.beyond(), log2_q4(64) - log2_q4(64));
  views.picture().at(kX - 6, kY) = 100;
  views.picture().at(kX - 7, kY) = 160;  // too far back, but for its other side
  EXPECT_EQ(views.beyond(), log2_q4(4) - log2_q4(64));
}

TEST(BeyondEdge, EachSideIsAskedAndTheWorstCounts) {
  const struct {
    int dx;
    int dy;
  } sides[] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  for (const auto& [dx, dy] : sides) {
    Views views;
    views.disparity().at(kX + 8 * dx, kY + 8 * dy) = Disparity::none();
    views.picture().at(kX + 2 * dx, kY + 2 * dy) = 130;
    EXPECT_EQ(views.beyond(), log2_q4(4) - log2_q4(34)) << dx << dy;
    views.disparity().at(kX - 8 * dx, kY - 8 * dy) = Disparity::none();
    EXPECT_EQ(views.beyond(), log2_q4(34) - log2_q4(4)) << dx << dy;
  }
}

TEST(BeyondEdge, TheBorderOfThePictureIsNoEnd) {
  Views views;
  std::ranges::fill(views.disparity().row(0).first(4), Disparity::none());
  for (const int x : {0, 5, kColumns - 1}) {
    for (const int y : {0, kRows - 1}) {
      EXPECT_EQ(views.beyond(x, y), 0) << x << ' ' << y;
    }
  }
  std::vector<Disparity> one{Disparity::from_raw(kRaw)};
  std::vector<std::uint8_t> grey{9};
  EXPECT_EQ(beyond_edge({{one.data(), 1, 1}, {grey.data(), 1, 1}}, {0, 0, kRaw, kMost}), 0);
}

}  // namespace
}  // namespace stof::dsp
