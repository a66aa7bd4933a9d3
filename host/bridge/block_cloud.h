#pragma once

#include <vector>

#include "dsp/base/status.h"
#include "host/client/frame/frame.h"
#include "host/client/frame/point_cloud.h"

namespace stof::bridge {

inline constexpr int kMostCloudStep = 64;

// A cloud of fewer points that hides no obstacle: of each block of step x step pixels the one with
// the nearest near bound, depth - width / 2 (where the width did not arrive: with the nearest
// depth), as dsp/fusion/decimate.h. Into `points` (cleared first), in raster order of the blocks;
// sources are not told. step: 1 to kMostCloudStep. kUnsupported: the frame has no calibration yet;
// kInvalidArgument: it is of another image size.
Status block_cloud(const client::Frame& frame, int step, std::vector<client::Point>& points);

}  // namespace stof::bridge
