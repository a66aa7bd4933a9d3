#include "host/calibrate/rig/target/pair_start.h"

#include <algorithm>

#include "dataset/files/file.h"
#include "host/calibrate/rig/target/board_pose.h"

namespace stof::host {
namespace {

struct BothPoses {
  std::optional<PoseUnknowns> left;
  std::optional<PoseUnknowns> right;
};

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

// The median of each number over the views that both eyes saw.
std::optional<PoseUnknowns> left_to_right_of(const std::vector<BothPoses>& poses) {
  std::vector<PoseUnknowns> each;
  for (const BothPoses& pose : poses) {
    if (pose.left && pose.right) {
      const Matrix3 turn = rotation_of(*pose.right) * rotation_of(*pose.left).transpose();
      each.push_back(
          pose_of(turn, translation_of(*pose.right) - turn * translation_of(*pose.left)));
    }
  }
  if (each.empty()) {
    return std::nullopt;
  }
  PoseUnknowns middle{};
  for (std::size_t i = 0; i < kPoseUnknowns; ++i) {
    std::vector<double> values;
    values.reserve(each.size());
    for (const PoseUnknowns& pose : each) {
      values.push_back(pose[i]);
    }
    middle[i] = median(std::move(values));
  }
  return middle;
}

// Of a board that the right eye alone saw.
PoseUnknowns seen_by_left(const PoseUnknowns& right, const PoseUnknowns& left_to_right) {
  const Matrix3 back = rotation_of(left_to_right).transpose();
  return pose_of(back * rotation_of(right),
                 back * (translation_of(right) - translation_of(left_to_right)));
}

std::vector<std::vector<PixelPoint>> seen(const std::vector<PairView>& views,
                                          std::vector<PixelPoint> PairView::* eye) {
  std::vector<std::vector<PixelPoint>> found;
  for (const PairView& view : views) {
    if (!(view.*eye).empty()) {
      found.push_back(view.*eye);
    }
  }
  return found;
}

}  // namespace

dataset::Loaded<PairStart> start_of(const Board& board, const std::vector<PairView>& views,
                                    int width, int height) {
  const std::optional<dsp::Pinhole> left =
      lens_of_views(board, seen(views, &PairView::left), width, height);
  const std::optional<dsp::Pinhole> right =
      lens_of_views(board, seen(views, &PairView::right), width, height);
  if (!left || !right) {
    return dataset::refuse(std::string("the ") + (left ? "right" : "left") +
                           " lens does not follow from these views: add views of the board tilted "
                           "by 20 to 40 degrees, to both sides and up and down");
  }
  std::vector<BothPoses> poses;
  poses.reserve(views.size());
  for (const PairView& view : views) {
    poses.push_back({view.left.empty() ? std::nullopt : pose_of_board(board, view.left, *left),
                     view.right.empty() ? std::nullopt : pose_of_board(board, view.right, *right)});
  }
  const std::optional<PoseUnknowns> left_to_right = left_to_right_of(poses);
  if (!left_to_right) {
    return dataset::refuse(
        "no view shows the board to both eyes: keep it in the middle between them");
  }
  PairStart start{
      .rig = {.left = *left, .right = *right, .left_to_right = transform_of(*left_to_right)},
      .boards = {}};
  for (std::size_t n = 0; n < views.size(); ++n) {
    if (!poses[n].left && !poses[n].right) {
      return dataset::refuse(views[n].name +
                             ": the board's pose does not follow from its corners: "
                             "take the view out");
    }
    start.boards.push_back(poses[n].left ? *poses[n].left
                                         : seen_by_left(*poses[n].right, *left_to_right));
  }
  return start;
}

}  // namespace stof::host
