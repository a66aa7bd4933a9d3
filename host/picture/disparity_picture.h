#pragma once

#include <optional>
#include <vector>

#include "host/picture/colour_scale.h"

namespace stof::host {

// Colours of disparities: near_px and more are warmest, far_px and less coldest, linear between.
// far_px < near_px. The ends of scale_colour() are left out, so that no disparity is as dark as
// "none".
struct DisparityScale {
  double far_px = 0;
  double near_px = 64;

  Rgb colour(double disparity_px) const;
  // Some five round disparities inside the scale, ascending.
  std::vector<double> ticks() const;
};

// Where a value is +inf: a fine, nearly black checker.
Rgb none_colour(int x, int y);

// A disparity map in px, +inf = none.
dataset::Image<Rgb> disparity_picture(const dataset::Image<float>& disparity,
                                      const DisparityScale& scale);
// A map of Z in metres, +inf = none.
dataset::Image<Rgb> metric_picture(const dataset::Image<float>& depth_m, const ColourScale& scale);

// The verdict on a pixel of a map.
enum class Finding : std::uint8_t {
  kUnknown,  // no truth
  kRight,
  kTooNear,  // disparity more than 1 px above the truth
  kTooFar,
  kMissing,         // there is truth, but no disparity
  kRightlyRemoved,  // a filter removed what was wrong
  kWronglyRemoved,  // a filter removed what was right
  kFilled,          // taken from the background
};
Rgb finding_colour(Finding finding);

// Findings as colours over a washed-out left picture; kRight shows the picture alone, kMissing the
// checker of none_colour(). Pixels with pale set (occluded ones) have half the strength. All of one
// size; `pale` may be absent.
dataset::Image<Rgb> finding_picture(const dataset::Image<Finding>& findings,
                                    const dataset::Image<std::uint8_t>& left,
                                    const std::optional<dataset::Image<std::uint8_t>>& pale);

// disparity against truth, both in px, +inf = none or unknown; of one size.
dataset::Image<Finding> differences(const dataset::Image<float>& disparity,
                                    const dataset::Image<float>& truth);

// A grey picture in colours that things are drawn on, as it is or halfway to white.
dataset::Image<Rgb> as_colour(const dataset::Image<std::uint8_t>& grey, bool washed_out);

// Frame of a rectangle of pixels x0 .. x1, y0 .. y1 (both included), `thickness` px outwards; what
// lies outside the picture is cut.
void draw_frame(dataset::Image<Rgb>& picture, int x0, int y0, int x1, int y1, int thickness,
                Rgb colour);

}  // namespace stof::host
