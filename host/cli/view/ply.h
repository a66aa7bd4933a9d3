#pragma once

#include <vector>

#include "dataset/dataset.h"
#include "host/client/frame/point_cloud.h"

namespace stof::host {

// PLY 1.0, binary little-endian. For each point float x, y, z (metres in the rectified left camera:
// x right, y down, z forward), float sigma (of z, a quarter of the published interval) and uchar
// source (dsp::Source). One line when it cannot be written.
std::expected<void, dataset::Problem> write_ply(const std::filesystem::path& file,
                                                const std::vector<client::Point>& cloud);

}  // namespace stof::host
