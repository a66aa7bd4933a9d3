#pragma once

#include <optional>

#include "dataset/image.h"

namespace stof::host {

// How far what a picture shows moved to the next one, px: the median distance of features, each
// found again up to 12 px away. None where fewer than 12 are found again: it shows too little, or
// moved by more.
std::optional<double> picture_motion(const dataset::Image<std::uint8_t>& before,
                                     const dataset::Image<std::uint8_t>& now);

}  // namespace stof::host
