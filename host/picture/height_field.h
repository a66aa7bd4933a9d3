#pragma once

#include <limits>

#include "host/picture/png.h"

namespace stof::host {

inline constexpr float kNoDisparity = std::numeric_limits<float>::infinity();

// How a height field stands and is looked at.
struct HeightFieldView {
  double yaw_deg = 26;    // the viewer stands to the left of the middle
  double pitch_deg = 20;  // and above it
  // Height of near_px above far_px, in picture widths: the lower of the two.
  double height = 0.42;
  double height_a_px = 0.024;
  int width = 900;  // px of the result; its height follows
};

// The 2.5D view of a disparity map: a height field over a plate, as high as the disparity says,
// textured with the left picture, lit from the upper left, in perspective, hidden surfaces removed.
// Planes of the world are planes of the height field. For display alone, steps of up to 1.25 px are
// smoothed; where neighbours differ by more than 2 px the surface is cut; where there is no
// disparity (+inf) the plate shows. far_px, the disparity at the plate, is below near_px; what lies
// outside of both is moved to them. The picture is cut so that the height field of `frame` fits in
// it: one frame makes pictures of several maps comparable. All of one size.
dataset::Image<Rgb> height_field_picture(const dataset::Image<float>& disparity,
                                         const dataset::Image<float>& frame, double far_px,
                                         double near_px,
                                         const dataset::Image<std::uint8_t>& texture,
                                         const HeightFieldView& view = {});

// A map for height_field_picture() as one smooth surface: each pixel becomes the mean of its
// neighbourhood's disparities that differ from it by at most `step_px`. +inf stays.
dataset::Image<float> smoothed_within(const dataset::Image<float>& disparity, int radius,
                                      float step_px);

}  // namespace stof::host
