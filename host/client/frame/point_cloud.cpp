#include "host/client/frame/point_cloud.h"

#include <span>

namespace stof::client {
namespace {

constexpr double kPixelScale = 65536;
constexpr double kMicrometres = 1e-6;
constexpr float kMillimetres = 1e-3F;

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

Status point_cloud(const Frame& frame, std::vector<Point>& points) {
  points.clear();
  if (!frame.calibration) {
    return Status::kUnsupported;
  }
  const wire::CalibrationPacket& calibration = *frame.calibration;
  if (frame.depth.width() != calibration.image_width ||
      frame.depth.height() != calibration.image_height) {
    return Status::kInvalidArgument;
  }
  const double unit = calibration.depth_unit_um * kMicrometres;
  const double cx = calibration.cx / kPixelScale;
  const double cy = calibration.cy / kPixelScale;
  const double fx = calibration.fx / kPixelScale;
  const double fy = calibration.fy / kPixelScale;
  for (int v = 0; v < frame.depth.height(); ++v) {
    const std::span<const dsp::QuarterMm> depth = frame.depth.row(v);
    for (int u = 0; u < frame.depth.width(); ++u) {
      const auto column = static_cast<std::size_t>(u);
      if (depth[column] == dsp::kNoDepth) {
        continue;
      }
      const double z = depth[column] * unit;
      points.push_back({.x = static_cast<float>((u - cx) / fx * z),
                        .y = static_cast<float>((v - cy) / fy * z),
                        .z = static_cast<float>(z),
                        .z_width = width_of(frame, v, column, unit),
                        .source = source_of(frame, v, column)});
    }
  }
  return Status::kOk;
}

void cloud_points(const Frame& frame, std::vector<Point>& points) {
  points.clear();
  constexpr float kUnit = 1.0F / dsp::kQuarterMmPerMetre;
  for (int v = 0; v < frame.cloud.height(); ++v) {
    for (const CloudPoint& point : frame.cloud.row(v)) {
      if (point.depth == dsp::kNoDepth) {
        continue;
      }
      points.push_back({.x = static_cast<float>(point.x_mm) * kMillimetres,
                        .y = static_cast<float>(point.y_mm) * kMillimetres,
                        .z = static_cast<float>(point.depth) * kUnit,
                        .z_width = static_cast<float>(point.interval_width) * kUnit});
    }
  }
}

}  // namespace stof::client
