#include "host/calibrate/rig/target/corner_refiner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <ceres/tiny_solver.h>

#include "host/calibrate/rig/target/board_perspective.h"

namespace stof::host {
namespace {

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
constexpr double kMostMisfit = 0.12;     // rms of grey values, of white less black
constexpr double kMostTurn = 0.3;        // rad
constexpr double kLeastAngle = 0.2;      // between both edges, its sine
constexpr int kMostSteps = 30;
constexpr double kSmallestStep = 1e-5;   // of all unknowns
constexpr double kSmallestGain = 1e-12;  // of the squared misfit
constexpr int kFewestCorners = 4;

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

// Grey values around a corner less the model's, over the first span: what ceres::TinySolver makes
// least. Unknowns: how far the corner moved, px; the turns of both edges, rad; blur, px; black and
// span over the first span.
class GreyMisfit {
 public:
  using Scalar = double;
  // NOLINTNEXTLINE(readability-identifier-naming): the solver's names
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = kUnknowns };

  GreyMisfit(const dataset::Image<float>& picture, const Frame& frame, const Model& start)
      : frame_(frame), start_(start) {
    Matrix2 normals;
    normals.row(0) = frame_.normal[0].transpose();
    normals.row(1) = frame_.normal[1].transpose();
    const Vector2 half =
        normals.inverse().cwiseAbs() * Vector2(frame_.reach[0] + 1, frame_.reach[1] + 1) +
        Vector2::Constant(kMostMoved);
    const Vector2 least = (start.at - half).array().floor();
    const Vector2 most = (start.at + half).array().ceil();
    const int right = std::min(picture.width - 1, static_cast<int>(most.x()));
    const int low = std::min(picture.height - 1, static_cast<int>(most.y()));
    for (int v = std::max(0, static_cast<int>(least.y())); v <= low; ++v) {
      for (int u = std::max(0, static_cast<int>(least.x())); u <= right; ++u) {
        pixels_.push_back({.at = Vector2(u, v), .grey = picture.view().at(u, v)});
      }
    }
  }

  // Black and white by the first places of the edges; false: there is no such step.
  bool start_levels() {
    Matrix2 normal = Matrix2::Zero();
    Vector2 right = Vector2::Zero();
    for (const Pixel& pixel : pixels_) {
      const Vector2 place = pixel.at - start_.at;
      const double x = frame_.normal[0].dot(place);
      const double y = frame_.normal[1].dot(place);
      const double weight = weight_of(frame_, x, y);
      if (!(weight > 0)) {
        continue;
      }
      const Vector2 row(1, white_at(frame_, x, y, start_.blur).value);
      normal += weight * row * row.transpose();
      right += weight * pixel.grey * row;
    }
    const Vector2 levels = normal.ldlt().solve(right);
    start_.black = levels(0);
    start_.span = levels(1);
    return levels.allFinite() && start_.span > 0;
  }

  Row start() const {
    Row row;
    row << 0, 0, 0, 0, start_.blur, start_.black / start_.span, 1;
    return row;
  }
  Model model_of(const Row& x) const {
    return {.at = start_.at + x.head<2>(),
            .turn = {x(2), x(3)},
            .blur = std::max(kLeastBlur, x(4)),
            .black = start_.span * x(5),
            .span = start_.span * x(6)};
  }

  // NOLINTNEXTLINE(readability-identifier-naming): the solver's name
  int NumResiduals() const { return static_cast<int>(pixels_.size()); }

  // Always true: where the model ran away, the misfit is too large to go there.
  bool operator()(const double* unknowns, double* misfit, double* slopes) const {
    const Row x = Eigen::Map<const Row>(unknowns);
    const Model model = model_of(x);
    Eigen::Map<Eigen::VectorXd> off(misfit, NumResiduals());
    off.setZero();
    if (!usable(x)) {
      off.setConstant(kFar);
      return true;
    }
    const std::array<Vector2, 2> n{turned(frame_.normal[0], model.turn[0]),
                                   turned(frame_.normal[1], model.turn[1])};
    const Eigen::VectorXd weights = weights_at(model.at).cwiseSqrt();
    using Slopes = Eigen::Matrix<double, Eigen::Dynamic, kUnknowns>;
    if (slopes != nullptr) {
      Eigen::Map<Slopes>(slopes, NumResiduals(), kUnknowns).setZero();
    }
    for (Eigen::Index i = 0; i < weights.size(); ++i) {
      if (!(weights(i) > 0)) {
        continue;
      }
      const Pixel& pixel = pixels_[static_cast<std::size_t>(i)];
      const Vector2 place = pixel.at - model.at;
      const White white = white_at(frame_, n[0].dot(place), n[1].dot(place), model.blur);
      off(i) = weights(i) * ((pixel.grey - model.black) / start_.span - x(6) * white.value);
      if (slopes == nullptr) {
        continue;
      }
      const Vector2 by_at = -white.by_x * n[0] - white.by_y * n[1];
      Row row;
      row << x(6) * by_at, x(6) * white.by_x * Vector2(-n[0].y(), n[0].x()).dot(place),
          x(6) * white.by_y * Vector2(-n[1].y(), n[1].x()).dot(place), x(6) * white.by_blur, 1,
          white.value;
      Eigen::Map<Slopes>(slopes, NumResiduals(), kUnknowns).row(i) = -weights(i) * row.transpose();
    }
    return true;
  }

  // Of the corner's place at the least misfit, px^2: grey values scatter alike and independently,
  // by as much as the model leaves. None where they do not tell all unknowns apart.
  std::optional<Matrix2> covariance(const Row& x) const {
    Eigen::VectorXd off(NumResiduals());
    Eigen::Matrix<double, Eigen::Dynamic, kUnknowns> slopes(NumResiduals(), int{kUnknowns});
    (*this)(x.data(), off.data(), slopes.data());
    const Eigen::VectorXd weights = weights_at(model_of(x).at);
    const double used = 1 / weights.squaredNorm();  // pixels, as if each counted whole or not
    if (!(used > kUnknowns + 1)) {
      return std::nullopt;
    }
    const double variance = off.squaredNorm() * used / (used - kUnknowns);
    using Square = Eigen::Matrix<double, kUnknowns, kUnknowns>;
    const Square normal = slopes.transpose() * slopes;
    const Square scatter = slopes.transpose() * weights.asDiagonal() * slopes;
    const Eigen::LDLT<Square> solver(normal);
    const Square inverse = solver.solve(Square::Identity());
    const Matrix2 found = (variance * inverse * scatter * inverse).topLeftCorner<2, 2>();
    const bool usable = solver.info() == Eigen::Success && found.allFinite() && found(0, 0) > 0 &&
                        found.determinant() > 0;
    return usable ? std::optional(found) : std::nullopt;
  }

 private:
  struct Pixel {
    Vector2 at;
    double grey = 0;
  };
  static constexpr double kFar = 1e3;

  // Of each pixel, 1 in all.
  Eigen::VectorXd weights_at(const Vector2& corner) const {
    Eigen::VectorXd weights(NumResiduals());
    for (Eigen::Index i = 0; i < weights.size(); ++i) {
      const Vector2 place = pixels_[static_cast<std::size_t>(i)].at - corner;
      weights(i) = weight_of(frame_, frame_.normal[0].dot(place), frame_.normal[1].dot(place));
    }
    return weights / weights.sum();
  }

  static bool usable(const Row& x) {
    return x.allFinite() && x.head<2>().norm() < kMostMoved && x(4) < kMostBlur &&
           std::abs(x(2)) < kMostTurn && std::abs(x(3)) < kMostTurn;
  }

  static Vector2 turned(const Vector2& normal, double angle) {
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    return {c * normal.x() - s * normal.y(), s * normal.x() + c * normal.y()};
  }

  const Frame& frame_;
  Model start_;
  std::vector<Pixel> pixels_;
};

// nullopt: it ran away, or shows no corner.
std::optional<PixelPoint> fitted_corner(const dataset::Image<float>& picture, const Frame& frame,
                                        const PixelPoint& corner, double least_span) {
  GreyMisfit misfit(picture, frame, {.at = {corner.u, corner.v}});
  if (!misfit.start_levels()) {
    return std::nullopt;
  }
  ceres::TinySolver<GreyMisfit> solver;
  solver.options = {.max_num_iterations = kMostSteps,
                    .parameter_tolerance = kSmallestStep,
                    .function_tolerance = kSmallestGain};
  Row x = misfit.start();
  solver.Solve(misfit, &x);
  const Model model = misfit.model_of(x);
  const double rms = std::sqrt(2 * solver.summary.final_cost);  // over the first span
  const bool corner_there = rms < kMostMisfit * x(6) && model.span > least_span;
  const std::optional<Matrix2> spread = corner_there ? misfit.covariance(x) : std::nullopt;
  if (!spread) {
    return std::nullopt;
  }
  return PixelPoint{.u = model.at.x(),
                    .v = model.at.y(),
                    .uu = (*spread)(0, 0),
                    .uv = (*spread)(0, 1),
                    .vv = (*spread)(1, 1)};
}

}  // namespace

std::vector<bool> refine_corners(const dataset::Image<float>& picture, const Board& board,
                                 std::vector<PixelPoint>& corners, const std::vector<bool>& asked) {
  const auto perspective = BoardPerspective::through(board, corners, kFewestCorners);
  std::vector<bool> fitted(corners.size());
  if (!perspective) {
    return fitted;
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
    if (!inside || (!asked.empty() && !asked[i])) {
      continue;
    }
    const bool even = (number / board.columns + number % board.columns) % 2 == 0;
    const std::optional<Frame> frame = frame_of(around, perspective->slope(board.at(number)), even);
    if (!frame) {
      continue;
    }
    if (const auto found = fitted_corner(picture, *frame, corner, least_span)) {
      corners[i] = *found;
      fitted[i] = true;
    }
  }
  return fitted;
}

std::vector<bool> refine_corners(const dataset::Image<std::uint8_t>& picture, const Board& board,
                                 std::vector<PixelPoint>& corners, const std::vector<bool>& asked) {
  dataset::Image<float> grey(picture.width, picture.height);
  std::ranges::copy(picture.pixels, grey.pixels.begin());
  return refine_corners(grey, board, corners, asked);
}

}  // namespace stof::host
