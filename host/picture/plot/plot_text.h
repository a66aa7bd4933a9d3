#pragma once

#include <string_view>

#include "host/picture/png.h"

namespace stof::host {

// Text of a plot: letters of 5x7 dots (two more below the base line), each dot kLabelDot pixels.
inline constexpr int kLabelDot = 2;
inline constexpr int kLabelHeight = 7 * kLabelDot;
int label_width(std::string_view text) noexcept;

// The upper left corner of the text is at (x, y); what lies outside of the picture is cut.
// Characters without a letter are drawn as '?'.
void draw_label(dataset::Image<Rgb>& picture, int x, int y, std::string_view text, Rgb colour);
// From the bottom upwards; (x, y) is the lower left corner of the turned text.
void draw_label_upwards(dataset::Image<Rgb>& picture, int x, int y, std::string_view text,
                        Rgb colour);

}  // namespace stof::host
