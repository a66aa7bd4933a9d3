#include "host/calibrate/rig/target/corner_refiner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <opencv2/calib3d.hpp>

#include "dsp/base/index.h"

namespace stof::host {
namespace {

using dsp::index;
using Vector2 = Eigen::Vector2d;
using Matrix2 = Eigen::Matrix2d;

constexpr double kMostReach = 10;  // px: farther away a lens bends edges
constexpr double kLeastReach = 1.5;
constexpr double kBlurReach = 1.5;  // px, by which what lies beyond stays away
constexpr double kTagBorder = 0.2;  // of a tag's side: two cells of ten
constexpr double kHalfPixel = 0.5;
constexpr double kFirstBlur = 0.6;  // of the lens, px
constexpr double kLeastBlur = 0.05;
constexpr double kMostBlur = 4;
constexpr double kMostMoved = 2;         // px
constexpr double kLeastContrast = 0.02;  // of the picture's span
constexpr double kMostMisfit = 0.2;      // rms of grey values, of white less black
constexpr double kMostTurn = 0.3;        // rad
constexpr double kLeastAngle = 0.2;      // between both edges, its sine
constexpr double kFirstDamping = 1e-4;
constexpr int kMostSteps = 30;
constexpr double kSmallestStep = 1e-4;  // px
constexpr std::size_t kFewestCorners = 4;

// What is printed around a corner, metres on the board; the same in all four squares.
struct Surroundings {
  double reach = 0;                                         // along an edge
  double inner = std::numeric_limits<double>::infinity();   // not so far from both edges
  double marker = std::numeric_limits<double>::infinity();  // where it begins in white squares
};

Surroundings surroundings_of(const Board& board) {
  const double side = board.square_m;
  switch (board.kind) {
    case Board::Kind::kCharuco: {
      const double marker = (1 - board.share) / 2 * side;
      const double cell = board.share * side / (board.bits + 2);
      return {.reach = side, .inner = marker + cell, .marker = marker};
    }
    case Board::Kind::kAprilGrid:
      return {.reach = board.share * side, .inner = kTagBorder * side};
    case Board::Kind::kChess:
      break;
  }
  return {.reach = side};
}

// Places of the board in the picture, as if the lens did not bend.
class Perspective {
 public:
  Perspective(const Board& board, const std::vector<PixelPoint>& corners) {
    std::vector<cv::Point2f> on_board;
    std::vector<cv::Point2f> in_picture;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (corners[i].seen()) {
        const std::array<double, 2> at = board.at(static_cast<int>(i));
        on_board.emplace_back(static_cast<float>(at[0]), static_cast<float>(at[1]));
        in_picture.emplace_back(static_cast<float>(corners[i].u), static_cast<float>(corners[i].v));
      }
    }
    if (on_board.size() >= kFewestCorners) {
      matrix_ = cv::findHomography(on_board, in_picture);
    }
  }

  bool known() const { return !matrix_.empty(); }

  // Pixels a metre: along rows of the board and from row to row.
  Matrix2 slope(const std::array<double, 2>& at) const {
    const auto h = [this](int row, int column) { return matrix_.at<double>(row, column); };
    const double w = h(2, 0) * at[0] + h(2, 1) * at[1] + h(2, 2);
    Matrix2 slope;
    for (int i = 0; i < 2; ++i) {
      const double place = (h(i, 0) * at[0] + h(i, 1) * at[1] + h(i, 2)) / w;
      for (int k = 0; k < 2; ++k) {
        slope(i, k) = (h(i, k) - place * h(2, k)) / w;
      }
    }
    return slope;
  }

 private:
  cv::Mat matrix_;
};

// A corner as it is fitted. Axis 0 crosses the edge between left and right squares, axis 1 that
// between upper and lower ones; black is where both count the same way.
struct Model {
  Vector2 at;
  std::array<double, 2> turn{};  // of each edge against its first normal, rad
  double blur = kFirstBlur;
  double black = 0;
  double span = 0;  // white less black
};
constexpr int kUnknowns = 7;
using Row = Eigen::Matrix<double, kUnknowns, 1>;

struct Frame {
  std::array<Vector2, 2> normal;
  std::array<double, 2> marker{};  // px from the edge
  std::array<double, 2> reach{};
  std::array<double, 2> inner{};
};

std::optional<Frame> frame_of(const Surroundings& around, const Matrix2& slope, bool even) {
  Frame frame;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const auto own = static_cast<Eigen::Index>(axis);
    const Vector2 along = slope.col(1 - own).normalized();  // the edge
    Vector2 normal(along.y(), -along.x());
    if (normal.dot(slope.col(own)) < 0) {
      normal = -normal;
    }
    const double px_per_m = normal.dot(slope.col(own));
    // The first square is black right and below of the corner, or left and below.
    frame.normal[axis] = axis == 0 && !even ? Vector2(-normal) : normal;
    frame.marker[axis] = around.marker * px_per_m;
    frame.reach[axis] = std::min(kMostReach, around.reach * px_per_m - kBlurReach);
    frame.inner[axis] = around.inner * px_per_m - kBlurReach;
    if (!(frame.reach[axis] >= kLeastReach)) {
      return std::nullopt;
    }
    // Where a marker is close, what is behind its border is as good as its border.
    frame.inner[axis] = std::max(frame.inner[axis], kLeastReach);
  }
  const Vector2& first = frame.normal[0];
  const Vector2& second = frame.normal[1];
  const double between = std::abs(first.x() * second.y() - first.y() * second.x());
  return between > kLeastAngle ? std::optional(frame) : std::nullopt;
}

double ramp(double inside) { return std::clamp(inside + 0.5, 0.0, 1.0); }

double weight_of(const Frame& frame, double across, double down) {
  const double x = std::abs(across);
  const double y = std::abs(down);
  return ramp(frame.reach[0] - x) * ramp(frame.reach[1] - y) *
         std::max(ramp(frame.inner[0] - x), ramp(frame.inner[1] - y));
}

// A step at 0, smoothed by the lens and by the pixel, which is as wide whichever way it is crossed;
// and its slopes.
struct Step {
  double value = 0;
  double by_place = 0;
  double by_blur = 0;
};
Step step_at(double place, double blur) {
  const auto bell = [](double z) {
    return std::exp(-z * z / 2) * std::numbers::inv_sqrtpi / std::numbers::sqrt2;
  };
  const auto below = [](double z) { return std::erfc(-z / std::numbers::sqrt2) / 2; };
  const double far = (place + kHalfPixel) / blur;
  const double near = (place - kHalfPixel) / blur;
  return {.value = blur * (far * below(far) + bell(far) - near * below(near) - bell(near)),
          .by_place = below(far) - below(near),
          .by_blur = bell(far) - bell(near)};
}
Step from(const Step& below) { return {1 - below.value, -below.by_place, -below.by_blur}; }

// White, 0..1, and its slopes by both places and the blur.
struct White {
  double value = 0;
  double by_x = 0;
  double by_y = 0;
  double by_blur = 0;

  void add(double sign, const Step& x, const Step& y) {
    value += sign * x.value * y.value;
    by_x += sign * x.by_place * y.value;
    by_y += sign * x.value * y.by_place;
    by_blur += sign * (x.by_blur * y.value + x.value * y.by_blur);
  }
};

White white_at(const Frame& frame, double x, double y, double blur) {
  White white;
  const Step right = step_at(x, blur);
  const Step below = step_at(y, blur);
  white.add(1, right, from(below));
  white.add(1, from(right), below);
  if (std::isfinite(frame.marker[0])) {
    const double gap_x = frame.marker[0];
    const double gap_y = frame.marker[1];
    white.add(-1, step_at(x - gap_x, blur), from(step_at(y + gap_y, blur)));
    white.add(-1, from(step_at(x + gap_x, blur)), step_at(y - gap_y, blur));
  }
  return white;
}

class CornerFit {
 public:
  CornerFit(const dataset::Image<float>& picture, const Frame& frame, Model start)
      : picture_(picture), frame_(frame), model_(std::move(start)) {}

  // False: it ran away, or shows no corner.
  bool run(double least_span) {
    if (!start_levels()) {
      return false;
    }
    const Vector2 start = model_.at;
    double damping = kFirstDamping;
    for (int step = 0; step < kMostSteps && improve(start, damping) > kSmallestStep; ++step) {
    }
    const double misfit = std::sqrt(sum(model_, nullptr));
    return misfit < kMostMisfit * model_.span && model_.span > least_span;
  }

  PixelPoint at() const { return {model_.at.x(), model_.at.y()}; }

 private:
  struct Normal {
    Eigen::Matrix<double, kUnknowns, kUnknowns> matrix =
        Eigen::Matrix<double, kUnknowns, kUnknowns>::Zero();
    Row right = Row::Zero();
  };

  // A step of Levenberg and Marquardt; how far the corner moves, px: 0 where nothing is better.
  double improve(const Vector2& start, double& damping) {
    constexpr int kTries = 8;
    constexpr double kLess = 0.2;
    constexpr double kMore = 8;
    Normal normal;
    const double cost = sum(model_, &normal);
    for (int tries = 0; tries < kTries; ++tries) {
      Eigen::Matrix<double, kUnknowns, kUnknowns> damped = normal.matrix;
      damped.diagonal() *= 1 + damping;
      const Row change = damped.ldlt().solve(normal.right);
      const Model next = moved(model_, change);
      if (change.allFinite() && usable(next, start) && sum(next, nullptr) <= cost) {
        damping *= kLess;
        model_ = next;
        return change.head<2>().norm();
      }
      damping *= kMore;
    }
    return 0;
  }

  static bool usable(const Model& model, const Vector2& start) {
    return (model.at - start).norm() < kMostMoved && model.blur < kMostBlur &&
           std::abs(model.turn[0]) < kMostTurn && std::abs(model.turn[1]) < kMostTurn;
  }

  static Model moved(const Model& model, const Row& by) {
    Model next = model;
    next.at += by.head<2>();
    next.turn[0] += by(2);
    next.turn[1] += by(3);
    next.blur = std::max(kLeastBlur, next.blur + by(4));
    next.black += by(5);
    next.span += by(6);
    return next;
  }

  // Calls value(grey, weight, place from the corner).
  template <typename Value>
  void each_pixel(const Model& model, const Value& value) const {
    Matrix2 normals;
    normals.row(0) = frame_.normal[0].transpose();
    normals.row(1) = frame_.normal[1].transpose();
    const Matrix2 back = normals.inverse().cwiseAbs();
    const Vector2 half = back * Vector2(frame_.reach[0] + 1, frame_.reach[1] + 1);
    const int left = std::max(0, static_cast<int>(std::floor(model.at.x() - half.x())));
    const int right =
        std::min(picture_.width - 1, static_cast<int>(std::ceil(model.at.x() + half.x())));
    const int top = std::max(0, static_cast<int>(std::floor(model.at.y() - half.y())));
    const int low =
        std::min(picture_.height - 1, static_cast<int>(std::ceil(model.at.y() + half.y())));
    for (int v = top; v <= low; ++v) {
      for (int u = left; u <= right; ++u) {
        const Vector2 place = Vector2(u, v) - model.at;
        const double weight =
            weight_of(frame_, frame_.normal[0].dot(place), frame_.normal[1].dot(place));
        if (weight > 0) {
          value(static_cast<double>(picture_.view().at(u, v)), weight, place);
        }
      }
    }
  }

  static Vector2 turned(const Vector2& normal, double angle) {
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    return {c * normal.x() - s * normal.y(), s * normal.x() + c * normal.y()};
  }

  // Weighted mean of squares; the normal equations too where they are asked for.
  double sum(const Model& model, Normal* normal) const {
    const std::array<Vector2, 2> n{turned(frame_.normal[0], model.turn[0]),
                                   turned(frame_.normal[1], model.turn[1])};
    double squares = 0;
    double weights = 0;
    each_pixel(model, [&](double grey, double weight, const Vector2& place) {
      const White white = white_at(frame_, n[0].dot(place), n[1].dot(place), model.blur);
      const double off = grey - model.black - model.span * white.value;
      squares += weight * off * off;
      weights += weight;
      if (normal == nullptr) {
        return;
      }
      const Vector2 by_at = -white.by_x * n[0] - white.by_y * n[1];
      const double by_first = white.by_x * Vector2(-n[0].y(), n[0].x()).dot(place);
      const double by_second = white.by_y * Vector2(-n[1].y(), n[1].x()).dot(place);
      Row row;
      row << model.span * by_at, model.span * by_first, model.span * by_second,
          model.span * white.by_blur, 1, white.value;
      normal->matrix += weight * row * row.transpose();
      normal->right += weight * off * row;
    });
    return weights > 0 ? squares / weights : std::numeric_limits<double>::infinity();
  }

  // Black and white by the first places of the edges.
  bool start_levels() {
    Matrix2 normal = Matrix2::Zero();
    Vector2 right = Vector2::Zero();
    each_pixel(model_, [&](double grey, double weight, const Vector2& place) {
      const White white =
          white_at(frame_, frame_.normal[0].dot(place), frame_.normal[1].dot(place), model_.blur);
      const Vector2 row(1, white.value);
      normal += weight * row * row.transpose();
      right += weight * grey * row;
    });
    const Vector2 levels = normal.ldlt().solve(right);
    model_.black = levels(0);
    model_.span = levels(1);
    return levels.allFinite() && model_.span > 0;
  }

  const dataset::Image<float>& picture_;
  const Frame& frame_;
  Model model_;
};

}  // namespace

void refine_corners(const dataset::Image<float>& picture, const Board& board,
                    std::vector<PixelPoint>& corners) {
  const Perspective perspective(board, corners);
  if (!perspective.known()) {
    return;
  }
  const auto [low, high] = std::ranges::minmax(picture.pixels);
  const double least_span = kLeastContrast * std::max(static_cast<double>(high - low), 1e-6);
  const Surroundings around = surroundings_of(board);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const int number = static_cast<int>(i);
    const PixelPoint& corner = corners[i];
    const bool inside = corner.seen() && corner.u > kLeastReach && corner.v > kLeastReach &&
                        corner.u < picture.width - 1 - kLeastReach &&
                        corner.v < picture.height - 1 - kLeastReach;
    if (!inside) {
      continue;
    }
    const bool even = (number / board.columns + number % board.columns) % 2 == 0;
    const std::optional<Frame> frame = frame_of(around, perspective.slope(board.at(number)), even);
    if (!frame) {
      continue;
    }
    CornerFit fit(picture, *frame, {.at = {corner.u, corner.v}});
    if (fit.run(least_span)) {
      corners[i] = fit.at();
    }
  }
}

void refine_corners(const dataset::Image<std::uint8_t>& picture, const Board& board,
                    std::vector<PixelPoint>& corners) {
  dataset::Image<float> grey(picture.width, picture.height);
  std::ranges::copy(picture.pixels, grey.pixels.begin());
  refine_corners(grey, board, corners);
}

}  // namespace stof::host
