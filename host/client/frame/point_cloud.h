#pragma once

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

// One point for each pixel that has a depth, in raster order, into `points` (cleared first).
// kUnsupported: the frame has no calibration yet; kInvalidArgument: it is of another image size.
Status point_cloud(const Frame& frame, std::vector<Point>& points);

// The points of the cloud stream, in raster order of their blocks, into `points` (cleared first);
// none where that stream was not sent. Needs no calibration; sources are not told.
void cloud_points(const Frame& frame, std::vector<Point>& points);

}  // namespace stof::client
