#include "host/client/frame/point_cloud.h"

namespace stof::client {
namespace {

constexpr double kPixelScale = 65536;
constexpr double kMicrometres = 1e-6;

float width_of(const Frame& frame, int v, std::size_t column, double unit) {
  if ((frame.received.row(v)[column] & kHasWidth) == 0) {
    return kUnknownWidth;
  }
  return static_cast<float>(frame.interval_width.row(v)[column] * unit);
}

dsp::Source source_of(const Frame& frame, int v, std::size_t column) {
  if ((frame.received.row(v)[column] & kHasSource) == 0) {
    return dsp::Source::kNone;
  }
  return frame.source.row(v)[column];
}

}  // namespace

PixelLens::PixelLens(const wire::CalibrationPacket& calibration) noexcept
    : unit_(calibration.depth_unit_um * kMicrometres),
      cx_(calibration.cx / kPixelScale),
      cy_(calibration.cy / kPixelScale),
      fx_(calibration.fx / kPixelScale),
      fy_(calibration.fy / kPixelScale) {}

Point PixelLens::point(const Frame& frame, int u, int v) const noexcept {
  const auto column = static_cast<std::size_t>(u);
  const double z = frame.depth.row(v)[column] * unit_;
  return {.x = static_cast<float>((u - cx_) / fx_ * z),
          .y = static_cast<float>((v - cy_) / fy_ * z),
          .z = static_cast<float>(z),
          .z_width = width_of(frame, v, column, unit_),
          .source = source_of(frame, v, column)};
}

Status point_cloud(const Frame& frame, std::vector<Point>& points) {
  points.clear();
  return each_point(
      frame, [&points](int /*u*/, int /*v*/, const Point& point) { points.push_back(point); });
}

void cloud_points(const Frame& frame, std::vector<Point>& points) {
  points.clear();
  each_cloud_point(frame, [&points](const Point& point) { points.push_back(point); });
}

}  // namespace stof::client
