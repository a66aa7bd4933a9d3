#include "host/calibrate/rig/live/sighting.h"

#include <future>
#include <utility>

#include "host/calibrate/rig/target/board_pose.h"

namespace stof::host {

Sighting sighting_of(PairView corners, const Board& board, const dsp::Pinhole& lens) {
  Sighting seen{.corners = std::move(corners), .pose = {}};
  const PairView& view = seen.corners;
  const std::vector<PixelPoint>& eye = view.left.empty() ? view.right : view.left;
  if (!eye.empty()) {
    if (const std::optional<PoseUnknowns> pose = pose_of_board(board, eye, lens)) {
      seen.pose = view_pose(board, view, *pose, {.left = lens, .right = lens, .left_to_right = {}});
    }
  }
  return seen;
}

Sighting sighting_of(const dataset::Image<std::uint8_t>& left,
                     const dataset::Image<std::uint8_t>& right, const Board& board,
                     const dsp::Pinhole& lens, std::string name, Corners how) {
  const auto find = how == Corners::kFine ? find_board : find_board_roughly;
  std::future<std::optional<FoundBoard>> beside =
      std::async(std::launch::async, [&] { return find(right, board); });
  std::optional<FoundBoard> by_left = find(left, board);
  std::optional<FoundBoard> by_right = beside.get();
  PairView corners{.name = std::move(name), .left = {}, .right = {}};
  if (by_left) {
    corners.left = std::move(by_left->corners);
  }
  if (by_right) {
    corners.right = std::move(by_right->corners);
  }
  Sighting seen = sighting_of(std::move(corners), board, lens);
  seen.left_blur_px = by_left ? by_left->blur_px : 0;
  seen.right_blur_px = by_right ? by_right->blur_px : 0;
  return seen;
}

dsp::Pinhole assumed_lens(int width, int height) {
  constexpr double kFocalPerWidth = 0.866;
  const double f = kFocalPerWidth * width;
  return {.width = width,
          .height = height,
          .fx = f,
          .fy = f,
          .cx = (width - 1) / 2.0,
          .cy = (height - 1) / 2.0};
}

}  // namespace stof::host
