#pragma once

#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "firmware/wire/messages/calibration.h"

namespace stof::firmware {

// The picture that a profile makes of a depth map: the decimated map (dsp/fusion/decimate.h) within
// these bounds, in steps of so many quarter millimetres. Steps far below the width of the intervals
// lose nothing that was known, and are what lets a line carry the rate: RVL of quarter millimetres
// saves little where neighbours lie centimetres apart.
struct PictureProfile {
  int width = 0;
  int height = 0;
  int unit = 1;
};
inline constexpr PictureProfile kCoarse{.width = 80, .height = 60, .unit = 64};    // 16 mm
inline constexpr PictureProfile kMedium{.width = 160, .height = 120, .unit = 16};  // 4 mm

// The smallest step with which a picture lies within the bounds: 640x480 becomes exactly 80x60 and
// 160x120, 640x400 becomes 80x50 and 160x100.
int profile_step(const PictureProfile& profile, int width, int height) noexcept;

// Depth into units, rounded towards the camera, and width into units, rounded so that the new
// interval holds the old one. A pixel with depth keeps one. Images of one size.
void coarsen(int unit, dsp::ImageView<dsp::QuarterMm> depth,
             dsp::ImageView<dsp::QuarterMm> width) noexcept;

// The calibration of a profile's picture of a map with that calibration. A pixel stands for the
// middle of its block, where it may be any of the block's pixels.
wire::CalibrationPacket profile_calibration(const wire::CalibrationPacket& calibration,
                                            const PictureProfile& profile) noexcept;

}  // namespace stof::firmware
