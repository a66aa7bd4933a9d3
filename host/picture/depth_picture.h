#pragma once

#include "dsp/base/fixed.h"
#include "host/picture/colour_scale.h"

namespace stof::host {

// Width in px of the legend that depth_picture() adds at the right.
inline constexpr int kLegendWidth = 84;

// A depth map in the colours of the scale, with the scale and its distances drawn beside it. Pixels
// without depth are a dark grey checker. The picture is as high as the map, at least 96 px.
dataset::Image<Rgb> depth_picture(const dataset::Image<dsp::QuarterMm>& depth,
                                  const ColourScale& scale);

// Draws `text` (digits, '.', and the letters of "none m") with its left edge at x and its middle at
// row y; what lies outside the picture is cut. Unknown characters are blank.
void draw_text(dataset::Image<Rgb>& picture, int x, int y, std::string_view text, Rgb colour);
// Width in px that draw_text() covers.
int text_width(std::string_view text);

}  // namespace stof::host
