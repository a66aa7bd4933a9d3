#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/fusion/decimate.h"
#include "dsp/fusion/depth_map.h"
#include "firmware/wire/frame/tiles.h"
#include "firmware/wire/messages/calibration.h"

// The stream of points: one of each block of a depth map (dsp/fusion/decimate.h).
namespace stof::wire {

inline constexpr std::size_t kPointBytes = 8;
inline constexpr int kLeastCloudStep = 2;

// X or Y in mm of a pixel with depth Z: (pixel - centre) Z / focal / 4, rounded to the nearest
// (halves up) and limited to what 16 bits hold. focal (positive) and centre in 1/65536 px.
std::int16_t point_mm(int pixel, dsp::QuarterMm depth, std::int32_t focal,
                      std::int32_t centre) noexcept;

// Adds the tiles; step: kLeastCloudStep to dsp::kMostBlock. fx and fy of the lens are positive.
void add_cloud_tiles(const dsp::DepthMap& map, int step, const CalibrationPacket& lens,
                     PartStore& store) noexcept;

}  // namespace stof::wire
