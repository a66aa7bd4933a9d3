#pragma once

#include <string>
#include <vector>

#include "host/picture/disparity_picture.h"

// Legends as HTML, drawn by the browser: sharp at every size, in the ink of the page.
namespace stof::host {

// A number with as many decimals as numbers `step` apart need.
std::string tick_text(double value, double step);

// Colour bar from far to near in px, and the checker of "none".
std::string disparity_legend(const DisparityScale& scale);
// The same in metres, near to far, logarithmic.
std::string depth_legend(const ColourScale& scale);
// From -most to most, as error_picture() draws values; the grey of "none".
std::string error_legend(double most, std::string_view unit);

// One swatch a finding, with the colour finding_picture() gives it.
struct KeyEntry {
  Finding finding;
  std::string meaning;  // text
};
std::string finding_legend(const std::vector<KeyEntry>& entries);
// The legend of a difference map, and of what a filter removed.
std::string difference_legend();
std::string removal_legend();
// Swatches of any colours.
std::string colour_legend(const std::vector<std::pair<Rgb, std::string>>& entries);

}  // namespace stof::host
