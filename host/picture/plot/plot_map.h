#pragma once

#include <string>

#include "host/picture/png.h"

namespace stof::host {

// A map of values, blue below 0, red above, white at 0, with the scale beside it. Values that are
// not finite are grey. Pixels are enlarged to whole squares.
dataset::Image<Rgb> map_picture(const dataset::Image<float>& values, const std::string& title,
                                const std::string& unit);

}  // namespace stof::host
