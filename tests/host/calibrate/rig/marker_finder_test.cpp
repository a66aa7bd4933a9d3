#include "host/calibrate/rig/target/marker_finder.h"

#include <cmath>

#include <gtest/gtest.h>

#include "host/calibrate/rig/target/target_sheet.h"
#include "tests/host/calibrate/rig/board_views.h"
#include "tests/host/calibrate/rig/rendered_plane.h"

namespace stof::host {
namespace {

using test::board_at;
using test::Gaussian;
using test::PlaneCamera;
using test::print_of;

Board named(const char* text) {
  const dataset::Loaded<Board> board = board_named(text);
  EXPECT_TRUE(board) << text;
  return board.value_or(Board{});
}

const PlaneCamera& camera() {
  static const PlaneCamera left(test::true_pair().left);
  return left;
}

struct Off {
  double rms_px = 0;
  double largest_px = 0;
  std::size_t seen = 0;
};

Off off(const FoundBoard& found, const Board& board, const PoseUnknowns& pose) {
  const LensUnknowns lens = unknowns_of(camera().lens());
  const Matrix3 turn = rotation_of(pose);
  Off off;
  for (int i = 0; i < board.corners(); ++i) {
    const PixelPoint& corner = found.corners[static_cast<std::size_t>(i)];
    if (!corner.seen()) {
      continue;
    }
    const std::array<double, 2> at = board.at(i);
    const Vector3 point = turn * Vector3(at[0], at[1], 0) + translation_of(pose);
    std::array<double, 2> pixel{};
    EXPECT_TRUE(project(lens.data(), {point.x(), point.y(), point.z()}, pixel));
    const double distance = std::hypot(corner.u - pixel[0], corner.v - pixel[1]);
    off.rms_px += distance * distance / 2;
    off.largest_px = std::max(off.largest_px, distance);
    ++off.seen;
  }
  off.rms_px = std::sqrt(off.rms_px / static_cast<double>(off.seen));
  return off;
}

TEST(MarkerFinder, FindsEveryCornerInItsPlaceAndOrder) {
  Gaussian random(1);
  for (const char* const name : {"charuco:9x6:0.04", "charuco:8x6:0.04:0.03:5x5",
                                 "charuco:7x5:0.05:0.0375:6x6", "aprilgrid:5x4:0.06:0.3"}) {
    const Board board = named(name);
    const test::Texture print = print_of(board);
    for (const Vector3& turn : {Vector3(0, 0, 0.07), Vector3(0.5, -0.3, 0.1),
                                Vector3(0.1, 0.6, -0.2), Vector3(0, 0.1, 3.1)}) {
      const PoseUnknowns pose = board_at(board, Vector3(0.02, -0.02, 0.75), turn);
      const std::optional<FoundBoard> found =
          find_board(camera().picture(pose, print, 2, random), board);
      ASSERT_TRUE(found) << name << ": " << turn.transpose();
      const Off here = off(*found, board, pose);
      EXPECT_GE(here.seen, static_cast<std::size_t>(board.corners()) * 9 / 10) << name;
      // Squares are 32 px wide, the window between a corner and the markers 4 px to each side.
      EXPECT_LT(here.rms_px, 0.15) << name << ": " << turn.transpose();
      EXPECT_LT(here.largest_px, 0.5) << name << ": " << turn.transpose();
      EXPECT_LT(found->blur_px, 0.9) << name;
    }
  }
}

TEST(MarkerFinder, FindsThePartOfABoardThatIsInThePicture) {
  Gaussian random(2);
  for (const char* const name : {"charuco:12x9:0.04", "aprilgrid:6x6:0.06:0.3"}) {
    const Board board = named(name);
    const PoseUnknowns pose = board_at(board, Vector3(0.3, 0.2, 0.7), Vector3(0.2, -0.2, 0.1));
    const std::optional<FoundBoard> found =
        find_board(camera().picture(pose, print_of(board), 2, random), board);
    ASSERT_TRUE(found) << name;
    const Off here = off(*found, board, pose);
    EXPECT_LT(here.seen, static_cast<std::size_t>(board.corners()));
    EXPECT_LT(here.rms_px, 0.1) << name;
    EXPECT_LT(here.largest_px, 0.5) << name;
  }
}

// Kalibr's sheets and OpenCV's have the same tags, and need not agree on which side is up.
TEST(MarkerFinder, TakesTagsThatStandOnTheirHeads) {
  Gaussian random(3);
  const Board board = named("aprilgrid:4x4:0.07:0.3");
  const PoseUnknowns pose = board_at(board, Vector3(0, 0, 0.8), Vector3(0.2, 0.3, 0.1));
  const std::optional<FoundBoard> found =
      find_board(camera().picture(pose, print_of(board, true), 2, random), board);
  ASSERT_TRUE(found);
  EXPECT_LT(off(*found, board, pose).rms_px, 0.1);
}

TEST(MarkerFinder, FindsNoBoardThatIsNotThereOrHardlyInThePicture) {
  Gaussian random(4);
  const Board board = named("charuco:9x6:0.04");
  EXPECT_FALSE(find_board(dataset::Image<std::uint8_t>(640, 480, 90), board));
  EXPECT_FALSE(find_board(dataset::Image<std::uint8_t>(9, 7, 90), board));
  const PoseUnknowns pose = board_at(board, Vector3(0, 0, 0.7), Vector3(0, 0, 0));
  const dataset::Image<std::uint8_t> picture = camera().picture(pose, print_of(board), 2, random);
  EXPECT_TRUE(find_board(picture, board));
  EXPECT_FALSE(find_board(picture, named("aprilgrid:5x4:0.06:0.3")));
  const PoseUnknowns beside = board_at(board, Vector3(0.52, 0.3, 0.7), Vector3(0, 0, 0));
  EXPECT_FALSE(find_board(camera().picture(beside, print_of(board), 2, random), board));
}

TEST(BoardNamed, TakesBoardsWithMarkers) {
  const Board charuco = named("charuco:9x6:0.04");
  EXPECT_EQ(charuco.share, 0.75);
  EXPECT_EQ(charuco.bits, 4);
  EXPECT_EQ(to_string(charuco), "charuco:9x6:0.04:0.03:4x4");
  EXPECT_EQ(named(to_string(charuco).c_str()).share, charuco.share);
  EXPECT_EQ(named("charuco:8x8:0.04:0.02:6x6").bits, 6) << "markers tell which way round it is";
  const Board grid = named("aprilgrid:6x5:0.088:0.3");
  EXPECT_EQ(grid.columns, 12);
  EXPECT_EQ(grid.rows, 10);
  EXPECT_NEAR(grid.at(3)[0], 0.088 * 2.3, 1e-12);
  EXPECT_EQ(to_string(grid), "aprilgrid:6x5:0.088:0.3");
  for (const char* const text :
       {"charuco:", "charuco:9x6", "charuco:9x6:0.04:0.04", "charuco:9x6:0.04:0.03:7x7",
        "charuco:9x6:0.04:0.03:4x4:1", "charuco:9x6:nan", "charuco:2x6:0.04", "aprilgrid:6x6:0.1",
        "aprilgrid:1x6:0.1:0.3", "aprilgrid:21x6:0.1:0.3", "aprilgrid:6x6:0.1:0",
        "aprilgrid:6x6:0.1:0.3:1", "Charuco:9x6:0.04"}) {
    EXPECT_FALSE(board_named(text)) << text;
  }
}

TEST(TargetSheet, OfABoardWithMarkersShowsThem) {
  constexpr double kScale = 8;  // pixels a millimetre
  for (const char* const name : {"charuco:9x6:0.024", "aprilgrid:6x4:0.03:0.3"}) {
    const Board board = named(name);
    const dataset::Loaded<Sheet> sheet = sheet_of(board, "a4");
    ASSERT_TRUE(sheet) << sheet.error().message;
    dataset::Image<std::uint8_t> paper(static_cast<int>(sheet->width_mm * kScale),
                                       static_cast<int>(sheet->height_mm * kScale), 255);
    const auto paint = [&](const Rectangle& r, std::uint8_t grey) {
      const auto px = [](double mm) { return static_cast<int>(std::lround(mm * kScale)); };
      for (int y = px(r.y_mm); y < px(r.y_mm + r.height_mm); ++y) {
        for (int x = px(r.x_mm); x < px(r.x_mm + r.width_mm); ++x) {
          paper.view().at(x, y) = grey;
        }
      }
    };
    for (const Rectangle& r : sheet->black) {
      paint(r, 0);
    }
    for (const Rectangle& r : sheet->white) {
      paint(r, 255);
    }
    const std::optional<FoundBoard> found = find_board(paper, board);
    ASSERT_TRUE(found) << name;
    EXPECT_EQ(seen_corners(found->corners), static_cast<std::size_t>(board.corners())) << name;
    const PixelPoint& first = found->corners.front();
    const PixelPoint& last = found->corners.back();
    const std::array<double, 2> far = board.at(board.corners() - 1);
    EXPECT_NEAR(last.u - first.u, far[0] * 1000 * kScale, 1) << name;
    EXPECT_NEAR(last.v - first.v, far[1] * 1000 * kScale, 1) << name;
    EXPECT_NE(pdf_bytes(*sheet).find("\n1 g\n"), std::string::npos);
  }
}

}  // namespace
}  // namespace stof::host
