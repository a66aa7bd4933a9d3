#include "host/calibrate/rig/target/corner_finder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "dsp/base/index.h"
#include "host/calibrate/rig/target/corner_filler.h"
#include "host/calibrate/rig/target/corner_refiner.h"
#include "host/calibrate/rig/target/marker_finder.h"

namespace stof::host {
namespace {

using dsp::index;

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr int kSmallestWindow = 2;  // half the side of what refines a corner, px
constexpr int kLargestWindow = 8;
constexpr double kWindowShare = 0.3;   // of the distance to the next corner
constexpr double kProfileShare = 0.3;  // of that distance, to both sides of an edge
constexpr double kMarkerFree = 0.9;    // of what lies between an edge and the marker beside it
constexpr double kTagShare = 0.18;     // of a tag's side: its border is two cells of ten
constexpr double kProfileStep = 0.25;  // px
constexpr double kLeastContrast = 20;  // grey values between black and white

// Borrowed: OpenCV's pictures are not read-only, and these functions only read.
cv::Mat borrowed(const dataset::Image<std::uint8_t>& picture) {
  return {picture.height, picture.width, CV_8UC1, const_cast<std::uint8_t*>(picture.pixels.data())};
}

struct Grid {
  std::vector<cv::Point2f> corners;
  int columns = 0;
  int rows = 0;
  const cv::Point2f& at(int column, int row) const {
    return corners[index(row * columns + column)];
  }
};

double distance(const cv::Point2f& a, const cv::Point2f& b) {
  return std::hypot(static_cast<double>(a.x - b.x), static_cast<double>(a.y - b.y));
}

double shortest_step(const Grid& grid) {
  double shortest = std::numeric_limits<double>::infinity();
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      if (column + 1 < grid.columns) {
        shortest = std::min(shortest, distance(grid.at(column, row), grid.at(column + 1, row)));
      }
      if (row + 1 < grid.rows) {
        shortest = std::min(shortest, distance(grid.at(column, row), grid.at(column, row + 1)));
      }
    }
  }
  return shortest;
}

double grey_at(const cv::Mat& picture, double x, double y) {
  const int left = static_cast<int>(std::floor(x));
  const int top = static_cast<int>(std::floor(y));
  if (left < 0 || top < 0 || left + 1 >= picture.cols || top + 1 >= picture.rows) {
    return kNothing;
  }
  const double fx = x - left;
  const double fy = y - top;
  const auto at = [&](int column, int row) {
    return static_cast<double>(picture.at<std::uint8_t>(row, column));
  };
  return (1 - fy) * ((1 - fx) * at(left, top) + fx * at(left + 1, top)) +
         fy * ((1 - fx) * at(left, top + 1) + fx * at(left + 1, top + 1));
}

// Of the square whose first corner this is: the mean of the middle.
double square_grey(const cv::Mat& picture, const Grid& grid, int column, int row) {
  const cv::Point2f middle = (grid.at(column, row) + grid.at(column + 1, row) +
                              grid.at(column, row + 1) + grid.at(column + 1, row + 1)) /
                             4;
  return grey_at(picture, static_cast<double>(middle.x), static_cast<double>(middle.y));
}

// Whether the squares with the parity of the first one are the darker ones.
bool first_is_black(const cv::Mat& picture, const Grid& grid) {
  double even = 0;
  double odd = 0;
  for (int row = 0; row + 1 < grid.rows; ++row) {
    for (int column = 0; column + 1 < grid.columns; ++column) {
      const double grey = square_grey(picture, grid, column, row);
      if (std::isfinite(grey)) {
        ((column + row) % 2 == 0 ? even : odd) += grey;
      }
    }
  }
  return even < odd;
}

// The width of the edge that crosses a -> b in the middle, as a Gaussian's standard deviation: the
// area between the profile and an ideal step is 2 sigma / sqrt(2 pi) of its height. NaN: no edge.
// `share`: of its length, how far to both sides nothing else begins.
double edge_width(const cv::Mat& picture, const PixelPoint& a, const PixelPoint& b, double share) {
  const double length = std::hypot(b.u - a.u, b.v - a.v);
  const double across_x = -(b.v - a.v) / length;
  const double across_y = (b.u - a.u) / length;
  const double middle_x = (a.u + b.u) / 2;
  const double middle_y = (a.v + b.v) / 2;
  const int reach = std::max(8, static_cast<int>(length * share / kProfileStep));
  std::vector<double> profile;
  for (int i = -reach; i <= reach; ++i) {
    const double along = i * kProfileStep;
    profile.push_back(grey_at(picture, middle_x + along * across_x, middle_y + along * across_y));
    if (!std::isfinite(profile.back())) {
      return kNothing;
    }
  }
  const std::size_t end = std::max<std::size_t>(2, profile.size() / 8);
  double low = 0;
  double high = 0;
  for (std::size_t i = 0; i < end; ++i) {
    low += profile[i] / static_cast<double>(end);
    high += profile[profile.size() - 1 - i] / static_cast<double>(end);
  }
  if (std::abs(high - low) < kLeastContrast) {
    return kNothing;
  }
  // The profile as 0..1; where it crosses 1/2 is the step.
  double before = 0;
  std::vector<double> part;
  for (const double grey : profile) {
    part.push_back(std::clamp((grey - low) / (high - low), 0.0, 1.0));
    before += 1 - part.back();
  }
  double area = 0;
  for (std::size_t i = 0; i < part.size(); ++i) {
    const double inside = std::clamp(before - static_cast<double>(i), 0.0, 1.0);
    area += std::abs(part[i] - (1 - inside));
  }
  constexpr double kSigmaOfArea = 1.2533141373155001;  // sqrt(2 pi) / 2
  return area * kProfileStep * kSigmaOfArea;
}

double median(std::vector<double> values) {
  if (values.empty()) {
    return kNothing;
  }
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

double profile_share(const Board& board) {
  switch (board.kind) {
    case Board::Kind::kCharuco:
      return std::min(kProfileShare, kMarkerFree * (1 - board.share) / 2);
    case Board::Kind::kAprilGrid:
      return std::min(kTagShare, kMarkerFree * board.share);
    case Board::Kind::kChess:
      break;
  }
  return kProfileShare;
}

bool look_for(const cv::Mat& picture, Grid& grid) {
  const cv::Size size(grid.columns, grid.rows);
  if (cv::findChessboardCorners(
          picture, size, grid.corners,
          cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK)) {
    return true;
  }
  return cv::findChessboardCornersSB(picture, size, grid.corners, cv::CALIB_CB_NORMALIZE_IMAGE);
}

void refine(const cv::Mat& picture, Grid& grid) {
  const int half = std::clamp(static_cast<int>(shortest_step(grid) * kWindowShare), kSmallestWindow,
                              kLargestWindow);
  constexpr int kMostSteps = 60;
  constexpr double kSmallestStep = 1e-3;
  cv::cornerSubPix(
      picture, grid.corners, cv::Size(half, half), cv::Size(-1, -1),
      cv::TermCriteria(cv::TermCriteria::EPS | cv::TermCriteria::COUNT, kMostSteps, kSmallestStep));
}

// lens: nullptr where it is not known.
std::optional<FoundBoard> find_refined(const dataset::Image<std::uint8_t>& picture,
                                       const Board& board, const dsp::Pinhole* lens) {
  std::optional<FoundBoard> found = find_board_roughly(picture, board);
  if (found) {
    refine_corners(picture, board, found->corners, {.lens = lens});
    if (board.has_markers()) {
      fill_corners(picture, board, found->corners);
    }
    found->blur_px = edge_blur(picture, board, found->corners);
  }
  return found;
}

}  // namespace

std::optional<FoundBoard> find_board_roughly(const dataset::Image<std::uint8_t>& picture,
                                             const Board& board) {
  if (board.has_markers()) {
    return find_marked_board(picture, board);
  }
  const cv::Mat grey = borrowed(picture);
  Grid grid{.corners = {}, .columns = board.columns, .rows = board.rows};
  if (!look_for(grey, grid) || grid.corners.size() != index(board.corners())) {
    return std::nullopt;
  }
  refine(grey, grid);
  // One of columns and rows is odd: turned by half a turn, black squares are white ones.
  if (!first_is_black(grey, grid)) {
    std::ranges::reverse(grid.corners);
  }
  FoundBoard found{.corners = {}, .blur_px = kNothing};
  for (const cv::Point2f& corner : grid.corners) {
    found.corners.push_back({.u = static_cast<double>(corner.x),
                             .v = static_cast<double>(corner.y),
                             .uu = kRoughPx * kRoughPx,
                             .vv = kRoughPx * kRoughPx});
  }
  return found;
}

std::optional<FoundBoard> find_board(const dataset::Image<std::uint8_t>& picture,
                                     const Board& board) {
  return find_refined(picture, board, nullptr);
}

std::optional<FoundBoard> find_board_through(const dsp::Pinhole& lens,
                                             const dataset::Image<std::uint8_t>& picture,
                                             const Board& board) {
  return find_refined(picture, board, &lens);
}

double edge_blur(const dataset::Image<std::uint8_t>& picture, const Board& board,
                 const std::vector<PixelPoint>& corners) {
  const cv::Mat grey = borrowed(picture);
  const double share = profile_share(board);
  std::array<std::vector<double>, 2> widths;
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      for (const int down : {0, 1}) {
        const int to_column = column + 1 - down;
        const int to_row = row + down;
        // Between tags there is no edge.
        const bool gap =
            board.kind == Board::Kind::kAprilGrid && (down == 0 ? column : row) % 2 != 0;
        if (gap || to_column >= board.columns || to_row >= board.rows) {
          continue;
        }
        const PixelPoint& from = corners[index(row * board.columns + column)];
        const PixelPoint& to = corners[index(to_row * board.columns + to_column)];
        const double width =
            from.seen() && to.seen() ? edge_width(grey, from, to, share) : kNothing;
        if (std::isfinite(width)) {
          widths[index(down)].push_back(width);
        }
      }
    }
  }
  const double along = median(widths[0]);
  const double down = median(widths[1]);
  return std::isfinite(along) && std::isfinite(down) ? std::max(along, down) : kNothing;
}

std::size_t seen_corners(const std::vector<PixelPoint>& corners) {
  return static_cast<std::size_t>(std::ranges::count_if(corners, &PixelPoint::seen));
}

}  // namespace stof::host
