#pragma once

#include <cstddef>
#include <vector>

#include "dsp/base/status.h"
#include "dsp/fusion/depth_map.h"
#include "host/client/frame/frame.h"

namespace stof::client {

inline constexpr float kUnknownWidth = -1;

// Metres in the rectified left camera: x right, y down, z forward.
struct Point {
  float x = 0;
  float y = 0;
  float z = 0;
  // The truth lies in z +- z_width / 2 (95 percent); kUnknownWidth when that did not arrive.
  float z_width = 0;
  dsp::Source source = dsp::Source::kNone;  // kNone: did not arrive
};

// Calls visit(u, v, point) for each pixel that has a depth, in raster order, and keeps nothing.
// Statuses as point_cloud().
template <typename Visit>
Status each_point(const Frame& frame, Visit&& visit);

// One point for each pixel that has a depth, in raster order, into `points` (cleared first).
// kUnsupported: the frame has no calibration yet; kInvalidArgument: it is of another image size.
Status point_cloud(const Frame& frame, std::vector<Point>& points);

// The points of the cloud stream, in raster order of their blocks, into `points` (cleared first);
// none where that stream was not sent. Needs no calibration; sources are not told.
void cloud_points(const Frame& frame, std::vector<Point>& points);

// The same, called back.
template <typename Visit>
void each_cloud_point(const Frame& frame, Visit&& visit) {
  constexpr float kUnit = 1.0F / dsp::kQuarterMmPerMetre;
  constexpr float kMillimetres = 1e-3F;
  for (int v = 0; v < frame.cloud.height(); ++v) {
    for (const CloudPoint& point : frame.cloud.row(v)) {
      if (point.depth != dsp::kNoDepth) {
        visit(Point{.x = static_cast<float>(point.x_mm) * kMillimetres,
                    .y = static_cast<float>(point.y_mm) * kMillimetres,
                    .z = static_cast<float>(point.depth) * kUnit,
                    .z_width = static_cast<float>(point.interval_width) * kUnit});
      }
    }
  }
}

// The lens of a frame's calibration, from pixels to metres.
class PixelLens {
 public:
  explicit PixelLens(const wire::CalibrationPacket& calibration) noexcept;
  // frame.depth has a value there.
  Point point(const Frame& frame, int u, int v) const noexcept;

 private:
  double unit_;
  double cx_;
  double cy_;
  double fx_;
  double fy_;
};

template <typename Visit>
Status each_point(const Frame& frame, Visit&& visit) {
  if (!frame.calibration) {
    return Status::kUnsupported;
  }
  if (frame.depth.width() != frame.calibration->image_width ||
      frame.depth.height() != frame.calibration->image_height) {
    return Status::kInvalidArgument;
  }
  const PixelLens lens(*frame.calibration);
  for (int v = 0; v < frame.depth.height(); ++v) {
    const auto depth = frame.depth.row(v);
    for (int u = 0; u < frame.depth.width(); ++u) {
      if (depth[static_cast<std::size_t>(u)] != dsp::kNoDepth) {
        visit(u, v, lens.point(frame, u, v));
      }
    }
  }
  return Status::kOk;
}

}  // namespace stof::client
