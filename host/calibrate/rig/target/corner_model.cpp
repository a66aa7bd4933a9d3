#include "host/calibrate/rig/target/corner_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stof::host {
namespace {

using Vector2 = Eigen::Vector2d;
using Matrix2 = Eigen::Matrix2d;

constexpr double kMostReach = 10;  // px
constexpr double kLeastReach = 1.5;
constexpr double kBlurReach = 1.5;   // px, by which what lies beyond stays away
constexpr double kTagBorder = 0.2;   // of a tag's side: two cells of ten
constexpr double kLeastAngle = 0.2;  // between both edges, its sine
constexpr double kFar = 6.5;         // standard deviations: nothing of a step is left there
constexpr double kNarrowest = 1e-3;  // px

double ramp(double inside) { return std::clamp(inside + 0.5, 0.0, 1.0); }

// What a pixel is across an edge. Its square, seen along the edge, is a trapezoid: one box smoothed
// by another. Half of their widths, px.
struct Aperture {
  double wide = 0;
  double narrow = 0;
};
Aperture aperture_across(const Vector2& normal) {
  const Vector2 half = normal.cwiseAbs() / 2;
  return {std::max(half.maxCoeff(), kNarrowest), std::max(half.minCoeff(), kNarrowest)};
}

// A step at 0, smoothed by lens and pixel, and its slopes by place and by the lens's variance.
struct Step {
  double value = 0;
  double by_place = 0;
  double by_blur = 0;
};

// The step smoothed by the lens alone has the integrals of the normal distribution; two boxes are
// differences of those. blur: a standard deviation.
Step step_at(double place, double blur, const Aperture& pixel) {
  const double end = pixel.wide + pixel.narrow + kFar * blur;
  if (std::abs(place) >= end) {
    return {.value = place > 0 ? 1.0 : 0.0};
  }
  Step step;
  for (const auto& [sign, shift] :
       {std::pair(1.0, pixel.wide + pixel.narrow), std::pair(-1.0, pixel.wide - pixel.narrow),
        std::pair(-1.0, pixel.narrow - pixel.wide), std::pair(1.0, -pixel.wide - pixel.narrow)}) {
    const double p = place + shift;
    const double z = p / blur;
    const double below = std::erfc(-z / std::numbers::sqrt2) / 2;
    const double bell = std::exp(-z * z / 2) * std::numbers::inv_sqrtpi / std::numbers::sqrt2;
    step.value += sign * ((p * p + blur * blur) * below + p * blur * bell) / 2;
    step.by_place += sign * (p * below + blur * bell);
    step.by_blur += sign * below / 2;
  }
  const double area = 4 * pixel.wide * pixel.narrow;
  return {step.value / area, step.by_place / area, step.by_blur / area};
}
Step from(const Step& below) { return {1 - below.value, -below.by_place, -below.by_blur}; }

// Adds what lies behind both steps. `together`: the covariance of what smooths both, px^2; steps
// that do not cross at a right angle are smoothed alike in part.
void add(double sign, const Step& x, const Step& y, double together, White& white) {
  white.value += sign * (x.value * y.value + together * x.by_place * y.by_place);
  white.by_x += sign * x.by_place * y.value;
  white.by_y += sign * x.value * y.by_place;
  white.by_blur += sign * (x.by_blur * y.value + x.value * y.by_blur);
}

}  // namespace

CornerPrint print_around_corners(const Board& board) {
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

double CornerFrame::weight(const Vector2& from_corner) const {
  const double x = std::abs(normal[0].dot(from_corner));
  const double y = std::abs(normal[1].dot(from_corner));
  return ramp(reach[0] - x) * ramp(reach[1] - y) * std::max(ramp(inner[0] - x), ramp(inner[1] - y));
}

std::optional<CornerFrame> frame_of(const CornerPrint& print, const BoardPerspective& perspective,
                                    const std::array<double, 2>& on_board, bool even) {
  const Matrix2 slope = perspective.slope(on_board);
  CornerFrame frame;
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
    frame.bend[axis] =
        frame.normal[axis].dot(perspective.bend(on_board, 1 - axis, print.reach / 2));
    frame.marker[axis] = print.marker * px_per_m;
    frame.reach[axis] = std::min(kMostReach, print.reach * px_per_m - kBlurReach);
    frame.inner[axis] = print.inner * px_per_m - kBlurReach;
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

EdgeDistance distance_from(const Vector2& normal, double bend, const Vector2& from_corner) {
  const Vector2 tangent(-normal.y(), normal.x());
  const double across = normal.dot(from_corner);
  const double along = tangent.dot(from_corner);
  return {.value = across - bend * along * along / 2,
          .by_place = normal - bend * along * tangent,
          .by_turn = along + bend * along * across};
}

White white_at(const CornerEdges& edges, double x, double y) {
  const double blur = std::sqrt(edges.blur);
  const std::array<Aperture, 2> pixel{aperture_across(edges.normal[0]),
                                      aperture_across(edges.normal[1])};
  const double together = (kPixelVariance + edges.blur) * edges.normal[0].dot(edges.normal[1]);
  White white;
  const Step right = step_at(x, blur, pixel[0]);
  const Step below = step_at(y, blur, pixel[1]);
  add(1, right, from(below), together, white);
  add(1, from(right), below, together, white);
  if (std::isfinite(edges.marker[0])) {
    const double gap_x = edges.marker[0];
    const double gap_y = edges.marker[1];
    add(-1, step_at(x - gap_x, blur, pixel[0]), from(step_at(y + gap_y, blur, pixel[1])), together,
        white);
    add(-1, from(step_at(x + gap_x, blur, pixel[0])), step_at(y - gap_y, blur, pixel[1]), together,
        white);
  }
  return white;
}

}  // namespace stof::host
