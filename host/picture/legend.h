#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/picture/png.h"

namespace stof::host {

// What the colours of a map mean.
struct Legend {
  std::function<Rgb(double place)> colour;            // of a bar from 0, its top, to 1
  std::vector<std::pair<double, std::string>> ticks;  // place on the bar and text, from the top
  std::function<Rgb(int x, int y)> none;              // of pixels without a value
};

// Width in px of what with_legend() adds at the right.
inline constexpr int kLegendWidth = 84;

// The map with the legend drawn beside it. The picture is as high as the map, at least 96 px.
dataset::Image<Rgb> with_legend(const dataset::Image<Rgb>& map, const Legend& legend);

// The map with a swatch and a word for each colour beside it, from the top; six fit any picture.
// Letters as of draw_text().
dataset::Image<Rgb> with_swatches(const dataset::Image<Rgb>& map,
                                  std::span<const std::pair<Rgb, std::string_view>> entries);

// Draws `text` (digits, '.', '%', and the letters of "none m near far stereo PMD both resolved
// conflict") with its left edge at x and
// its middle at row y; what lies outside the picture is cut. Unknown characters are blank.
void draw_text(dataset::Image<Rgb>& picture, int x, int y, std::string_view text, Rgb colour);
// Width in px that draw_text() covers.
int text_width(std::string_view text);

}  // namespace stof::host
