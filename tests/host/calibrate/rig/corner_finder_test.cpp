#include "host/calibrate/rig/target/corner_finder.h"

#include <cmath>

#include <gtest/gtest.h>

#include "host/calibrate/rig/target/target_sheet.h"
#include "tests/host/calibrate/rig/board_views.h"
#include "tests/host/calibrate/rig/rendered_plane.h"

namespace stof::host {
namespace {

using test::board_at;
using test::chessboard;
using test::Gaussian;
using test::PlaneCamera;

constexpr Board kBoard{.columns = 9, .rows = 6, .square_m = 0.03};

const PlaneCamera& camera() {
  static const PlaneCamera left(test::true_pair().left);
  return left;
}

double rms(const std::vector<PixelPoint>& a, const std::vector<PixelPoint>& b) {
  double squares = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    squares += std::pow(a[i].u - b[i].u, 2) + std::pow(a[i].v - b[i].v, 2);
  }
  return std::sqrt(squares / static_cast<double>(2 * a.size()));
}

TEST(CornerFinder, FindsEveryCornerInItsPlaceAndOrder) {
  Gaussian random(1);
  // Upside down too: only the colours of the squares tell.
  for (const Vector3& turn : {Vector3(0, 0, 0.07), Vector3(0.5, -0.3, 0.1), Vector3(0.1, 0.6, -0.2),
                              Vector3(0, 0.1, 3.1)}) {
    const PoseUnknowns pose = board_at(kBoard, Vector3(0.03, -0.02, 0.6), turn);
    const std::optional<FoundBoard> found =
        find_board(camera().picture(pose, chessboard(kBoard), 2, random), kBoard);
    ASSERT_TRUE(found) << turn.transpose();
    EXPECT_LT(rms(found->corners, test::seen_by(camera().lens(), pose, kBoard, 0, random)), 0.1)
        << turn.transpose();
    EXPECT_LT(found->blur_px, 0.8);
  }
}

TEST(CornerFinder, TellsHowBlurredABoardIs) {
  Gaussian random(2);
  const PoseUnknowns pose = board_at(kBoard, Vector3(0, 0, 0.5), Vector3(0.2, 0.1, 0));
  for (const int smear : {4, 8}) {
    const std::optional<FoundBoard> found =
        find_board(camera().picture(pose, chessboard(kBoard), 1, random, smear), kBoard);
    ASSERT_TRUE(found);
    // A box of n + 1 pixels has a quarter of its width between profile and step; a Gaussian of
    // sigma 0.313 times that width has as much.
    EXPECT_NEAR(found->blur_px, 0.313 * (smear + 1), 0.35) << smear;
  }
}

TEST(CornerFinder, FindsNoBoardThatIsNotThereOrNotWhole) {
  Gaussian random(3);
  EXPECT_FALSE(find_board(dataset::Image<std::uint8_t>(640, 480, 90), kBoard));
  EXPECT_FALSE(find_board(dataset::Image<std::uint8_t>(7, 5, 90), kBoard));
  const PoseUnknowns cut = board_at(kBoard, Vector3(0.3, 0, 0.6), Vector3(0, 0, 0));
  EXPECT_FALSE(find_board(camera().picture(cut, chessboard(kBoard), 1, random), kBoard));
}

TEST(BoardNamed, TakesNothingButABoard) {
  const dataset::Loaded<Board> board = board_named("9x6:0.030");
  ASSERT_TRUE(board);
  EXPECT_EQ(board->columns, 9);
  EXPECT_EQ(board->square_m, 0.03);
  EXPECT_EQ(to_string(*board), "9x6:0.03");
  for (const char* const text : {"", "9x6", "9x6:", "x6:0.03", "9x6:0", "9x6:nan", "2x6:0.03",
                                 "9x6:0.03m", "99x6:0.03", "8x6:0.03", "9x7:0.03", "9:6x0.03"}) {
    EXPECT_FALSE(board_named(text)) << text;
  }
}

// The sheet at 4 pixels a millimetre.
dataset::Image<std::uint8_t> printed_sheet(const Sheet& sheet) {
  constexpr double kScale = 4;
  dataset::Image<std::uint8_t> paper(static_cast<int>(sheet.width_mm * kScale),
                                     static_cast<int>(sheet.height_mm * kScale), 255);
  for (const Rectangle& r : sheet.black) {
    for (int y = static_cast<int>(std::lround(r.y_mm * kScale));
         y < static_cast<int>(std::lround((r.y_mm + r.height_mm) * kScale)); ++y) {
      for (int x = static_cast<int>(std::lround(r.x_mm * kScale));
           x < static_cast<int>(std::lround((r.x_mm + r.width_mm) * kScale)); ++x) {
        paper.view().at(x, y) = 0;
      }
    }
  }
  return paper;
}

TEST(TargetSheet, HasTheBoardInTrueSize) {
  constexpr Board kPrinted{.columns = 9, .rows = 6, .square_m = 0.024};
  const dataset::Loaded<Sheet> sheet = sheet_of(kPrinted, "a4");
  ASSERT_TRUE(sheet) << sheet.error().message;
  EXPECT_EQ(sheet->width_mm, 297);
  const std::optional<FoundBoard> found = find_board(printed_sheet(*sheet), kPrinted);
  ASSERT_TRUE(found);
  const PixelPoint& first = found->corners.front();
  const PixelPoint& last = found->corners.back();
  EXPECT_NEAR(last.u - first.u, 8 * 24 * 4, 1);
  EXPECT_NEAR(last.v - first.v, 5 * 24 * 4, 1);
}

TEST(TargetSheet, IsRefusedWhereThePaperIsTooSmallOrUnknown) {
  EXPECT_FALSE(sheet_of({.columns = 9, .rows = 6, .square_m = 0.05}, "a4"));
  EXPECT_TRUE(sheet_of({.columns = 9, .rows = 6, .square_m = 0.05}, "a2"));
  EXPECT_FALSE(sheet_of(kBoard, "letter"));
}

TEST(TargetSheet, ThePdfsTableNamesWhereItsObjectsAre) {
  const dataset::Loaded<Sheet> sheet = sheet_of({.columns = 9, .rows = 6, .square_m = 0.024}, "a4");
  ASSERT_TRUE(sheet);
  const std::string pdf = pdf_bytes(*sheet);
  EXPECT_TRUE(pdf.starts_with("%PDF-1.4\n"));
  EXPECT_TRUE(pdf.ends_with("%%EOF\n"));
  const std::size_t table = std::stoul(pdf.substr(pdf.rfind("startxref") + 10));
  ASSERT_EQ(pdf.substr(table, 9), "xref\n0 6\n");
  for (std::size_t n = 1; n <= 5; ++n) {
    const std::size_t at = std::stoul(pdf.substr(table + 9 + 20 * n, 10));
    EXPECT_EQ(pdf.substr(at, 7), std::to_string(n) + " 0 obj") << n;
  }
  EXPECT_NE(pdf.find("/MediaBox [0 0 841.8898 595.2756]"), std::string::npos);
}

}  // namespace
}  // namespace stof::host
