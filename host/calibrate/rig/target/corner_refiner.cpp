#include "host/calibrate/rig/target/corner_refiner.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <ceres/tiny_solver.h>

#include "host/calibrate/rig/target/board_perspective.h"
#include "host/calibrate/rig/target/corner_model.h"

namespace stof::host {
namespace {

using Vector2 = Eigen::Vector2d;
using Matrix2 = Eigen::Matrix2d;

constexpr double kLeastReach = 1.5;   // px, to the picture's border
constexpr double kFirstBlur = 0.36;   // variance of the lens's point spread, px^2
constexpr double kLeastBlur = 0.005;  // less is as sharp as pixels are
constexpr double kMostBlur = 16;
constexpr double kMostMoved = 2;         // px
constexpr double kMostFalloff = 0.08;    // of the light, a pixel
constexpr double kMostCurve = 0.01;      // of its logarithm, 1/px^2
constexpr double kFewestForLight = 30;   // pixels that tell how light falls off
constexpr double kFewestForCurve = 60;   // and how that changes
constexpr double kLeastContrast = 0.02;  // of the picture's span
constexpr double kMostMisfit = 0.12;     // rms of grey values, of white less black
constexpr double kMostTurn = 0.3;        // rad
constexpr int kMostSteps = 30;
constexpr double kSmallestStep = 1e-5;   // of all unknowns
constexpr double kSmallestGain = 1e-12;  // of the squared misfit
constexpr int kFewestCorners = 4;

// A corner as it is fitted.
struct Model {
  Vector2 at;
  std::array<double, 2> turn{};  // of each edge against its first normal, rad
  double blur = kFirstBlur;
  double black = 0;
  double span = 0;  // white less black
  // How much brighter both are a pixel to the right, and down; and how that changes: the first and
  // second derivatives of the light's logarithm, 1/px and 1/px^2.
  Vector2 falloff = Vector2::Zero();
  Matrix2 curve = Matrix2::Zero();
};
constexpr int kUnknowns = 12;
using Row = Eigen::Matrix<double, kUnknowns, 1>;

Vector2 turned(const Vector2& normal, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return {c * normal.x() - s * normal.y(), s * normal.x() + c * normal.y()};
}

// Grey values around a corner less the model's, over the first span: what ceres::TinySolver makes
// least. Unknowns: how far the corner moved, px; the turns of both edges, rad; the blur's
// variance, px^2; black and span over the first span; the light's falloff, 1/px, and its curve
// along rows, along both, along columns, 1/px^2. More rows hold what pixels do not tell: where few
// show the corner, falloff and curve at 0; and the blur of a picture that is as sharp as pixels
// are.
class GreyMisfit {
 public:
  using Scalar = double;
  // NOLINTNEXTLINE(readability-identifier-naming): the solver's names
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = kUnknowns };

  GreyMisfit(const dataset::Image<float>& picture, const CornerFrame& frame, const Model& start)
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
    const double used = 1 / weights_at(start.at).squaredNorm();
    if (!(used >= kFewestForLight)) {
      held_light_ = kLight;
    } else if (!(used >= kFewestForCurve)) {
      held_light_ = kLight - 2;
    }
  }

  // Black and white by the first places of the edges; false: there is no such step.
  bool start_levels() {
    Matrix2 normal = Matrix2::Zero();
    Vector2 right = Vector2::Zero();
    const CornerEdges edges = edges_of(start_);
    for (const Pixel& pixel : pixels_) {
      const Vector2 place = pixel.at - start_.at;
      const double weight = frame_.weight(place);
      if (!(weight > 0)) {
        continue;
      }
      const double x = distance_from(edges.normal[0], frame_.bend[0], place).value;
      const double y = distance_from(edges.normal[1], frame_.bend[1], place).value;
      const Vector2 row(1, white_at(edges, x, y).value);
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
    row << 0, 0, 0, 0, start_.blur, start_.black / start_.span, 1, 0, 0, 0, 0, 0;
    return row;
  }
  Model model_of(const Row& x) const {
    return {.at = start_.at + x.head<2>(),
            .turn = {x(2), x(3)},
            .blur = std::max(kLeastBlur, x(kBlur)),
            .black = start_.span * x(5),
            .span = start_.span * x(6),
            .falloff = x.segment<2>(kFalloff),
            .curve = curve_of(x)};
  }

  // NOLINTNEXTLINE(readability-identifier-naming): the solver's name
  int NumResiduals() const { return static_cast<int>(pixels_.size()) + kHeldRows; }

  // Always true: where the model ran away, the misfit is too large to go there.
  bool operator()(const double* unknowns, double* misfit, double* slopes) const {
    const Row x = Eigen::Map<const Row>(unknowns);
    Eigen::Map<Eigen::VectorXd> off(misfit, NumResiduals());
    off.setZero();
    if (!usable(x)) {
      off.setConstant(kFar);
      return true;
    }
    const Model model = model_of(x);
    const CornerEdges edges = edges_of(model);
    const Eigen::VectorXd weights = weights_at(model.at).cwiseSqrt();
    if (slopes != nullptr) {
      Eigen::Map<Slopes>(slopes, NumResiduals(), kUnknowns).setZero();
    }
    for (Eigen::Index i = 0; i < weights.size(); ++i) {
      if (!(weights(i) > 0)) {
        continue;
      }
      const Pixel& pixel = pixels_[static_cast<std::size_t>(i)];
      Row row;
      const double wanted = grey_of(x, model, edges, pixel.at, row);
      off(i) = weights(i) * (pixel.grey / start_.span - wanted);
      if (slopes != nullptr) {
        Eigen::Map<Slopes>(slopes, NumResiduals(), kUnknowns).row(i) =
            -weights(i) * row.transpose();
      }
    }
    hold(x, off, slopes);
    return true;
  }

  // Of the corner's place at the least misfit, px^2: grey values scatter alike and independently,
  // by as much as the model leaves. None where they do not tell all unknowns apart.
  std::optional<Matrix2> covariance(const Row& x) const {
    Eigen::VectorXd off(NumResiduals());
    Slopes slopes(NumResiduals(), int{kUnknowns});
    (*this)(x.data(), off.data(), slopes.data());
    Eigen::VectorXd weights = Eigen::VectorXd::Zero(NumResiduals());
    weights.head(NumResiduals() - kHeldRows) = weights_at(model_of(x).at);
    const double used = 1 / weights.squaredNorm();  // pixels, as if each counted whole or not
    const int fitted = kUnknowns - held_light_ - (x(kBlur) < kLeastBlur ? 1 : 0);
    if (!(used > fitted + 1)) {
      return std::nullopt;
    }
    const double variance = off.squaredNorm() * used / (used - fitted);
    using Square = Eigen::Matrix<double, kUnknowns, kUnknowns>;
    const Square normal = slopes.transpose() * slopes;
    const Square scatter = slopes.transpose() * weights.asDiagonal() * slopes;
    const Eigen::LDLT<Square> solver(normal);
    const Square inverse = solver.solve(Square::Identity());
    const Matrix2 found = (variance * inverse * scatter * inverse).topLeftCorner<2, 2>();
    const bool usable = solver.info() == Eigen::Success && found.allFinite() && found(0, 0) > 0 &&
                        found.determinant() > 0 && found.trace() < kMostMoved * kMostMoved;
    return usable ? std::optional(found) : std::nullopt;
  }

 private:
  struct Pixel {
    Vector2 at;
    double grey = 0;
  };
  using Slopes = Eigen::Matrix<double, Eigen::Dynamic, kUnknowns>;
  static constexpr double kFar = 1e3;
  static constexpr int kBlur = 4;  // the unknowns
  static constexpr int kFalloff = 7;
  static constexpr int kCurve = 9;
  static constexpr int kLight = 5;          // of falloff and curve
  static constexpr double kCurveHold = 30;  // px: what is held is next to nothing
  static constexpr int kHeldRows = kLight + 1;

  static Matrix2 curve_of(const Row& x) {
    Matrix2 curve;
    curve << x(kCurve), x(kCurve + 1), x(kCurve + 1), x(kCurve + 2);
    return curve;
  }

  void hold(const Row& x, Eigen::Map<Eigen::VectorXd>& off, double* slopes) const {
    Eigen::Matrix<double, kHeldRows, kUnknowns> rows;
    rows.setZero();
    for (int i = kLight - held_light_; i < kLight; ++i) {
      const double hold = i < kCurve - kFalloff ? 1 : kCurveHold;
      off(off.size() - kHeldRows + i) = hold * x(kFalloff + i);
      rows(i, kFalloff + i) = hold;
    }
    if (x(kBlur) < kLeastBlur) {
      off(off.size() - 1) = x(kBlur) - kLeastBlur;
      rows(kLight, kBlur) = 1;
    }
    if (slopes != nullptr) {
      Eigen::Map<Slopes>(slopes, NumResiduals(), kUnknowns).bottomRows<kHeldRows>() = rows;
    }
  }

  CornerEdges edges_of(const Model& model) const {
    return {.normal = {turned(frame_.normal[0], model.turn[0]),
                       turned(frame_.normal[1], model.turn[1])},
            .marker = frame_.marker,
            .blur = model.blur};
  }

  // Of a pixel by the model, over the first span, and its slopes by the unknowns.
  double grey_of(const Row& x, const Model& model, const CornerEdges& edges, const Vector2& pixel,
                 Row& slopes) const {
    // What is smoothed is the lit print: a pixel has more of its brighter side, as if it lay there.
    const double spread = kPixelVariance + model.blur;
    const Vector2 from_start = pixel - start_.at;  // where the light is 1
    const Vector2 falloff = model.falloff + model.curve * from_start;
    const Vector2 place = pixel - model.at + spread * falloff;
    const EdgeDistance across = distance_from(edges.normal[0], frame_.bend[0], place);
    const EdgeDistance down = distance_from(edges.normal[1], frame_.bend[1], place);
    const White white = white_at(edges, across.value, down.value);
    const double light = std::exp((model.falloff + falloff).dot(from_start) / 2);
    const double lit = light * x(6);
    const double print = x(5) + x(6) * white.value;
    const Vector2 by_place = lit * (white.by_x * across.by_place + white.by_y * down.by_place);
    const bool blurred = x(kBlur) >= kLeastBlur;
    const double x_off = from_start.x();
    const double y_off = from_start.y();
    const Vector2 moved = spread * by_place;
    slopes << -by_place, lit * white.by_x * across.by_turn, lit * white.by_y * down.by_turn,
        blurred ? lit * white.by_blur + by_place.dot(falloff) : 0.0, light, light * white.value,
        light * print * from_start + moved, light * print * x_off * x_off / 2 + moved.x() * x_off,
        light * print * x_off * y_off + moved.x() * y_off + moved.y() * x_off,
        light * print * y_off * y_off / 2 + moved.y() * y_off;
    return light * print;
  }

  // Of each pixel, 1 in all.
  Eigen::VectorXd weights_at(const Vector2& corner) const {
    Eigen::VectorXd weights(static_cast<Eigen::Index>(pixels_.size()));
    for (Eigen::Index i = 0; i < weights.size(); ++i) {
      weights(i) = frame_.weight(pixels_[static_cast<std::size_t>(i)].at - corner);
    }
    return weights / weights.sum();
  }

  static bool usable(const Row& x) {
    return x.allFinite() && x.head<2>().norm() < kMostMoved && x(kBlur) < kMostBlur &&
           std::abs(x(2)) < kMostTurn && std::abs(x(3)) < kMostTurn &&
           x.segment<2>(kFalloff).norm() < kMostFalloff &&
           x.segment<3>(kCurve).cwiseAbs().maxCoeff() < kMostCurve;
  }

  const CornerFrame& frame_;
  Model start_;
  std::vector<Pixel> pixels_;
  int held_light_ = 0;  // the last so many of falloff and curve
};

// nullopt: it ran away, or shows no corner.
std::optional<PixelPoint> fitted_corner(const dataset::Image<float>& picture,
                                        const CornerFrame& frame, const PixelPoint& corner,
                                        double least_span) {
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
                                 std::vector<PixelPoint>& corners, const RefineOptions& options) {
  const auto perspective = BoardPerspective::through(board, corners, kFewestCorners, options.lens);
  std::vector<bool> fitted(corners.size());
  if (!perspective) {
    return fitted;
  }
  const auto [low, high] = std::ranges::minmax(picture.pixels);
  const double least_span = kLeastContrast * std::max(static_cast<double>(high - low), 1e-6);
  const CornerPrint print = print_around_corners(board);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const int number = static_cast<int>(i);
    const PixelPoint& corner = corners[i];
    const bool inside = corner.seen() && corner.u > kLeastReach && corner.v > kLeastReach &&
                        corner.u < picture.width - 1 - kLeastReach &&
                        corner.v < picture.height - 1 - kLeastReach;
    if (!inside || (!options.asked.empty() && !options.asked[i])) {
      continue;
    }
    const bool even = (number / board.columns + number % board.columns) % 2 == 0;
    const std::optional<CornerFrame> frame = frame_of(print, *perspective, board.at(number), even);
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
                                 std::vector<PixelPoint>& corners, const RefineOptions& options) {
  dataset::Image<float> grey(picture.width, picture.height);
  std::ranges::copy(picture.pixels, grey.pixels.begin());
  return refine_corners(grey, board, corners, options);
}

}  // namespace stof::host
