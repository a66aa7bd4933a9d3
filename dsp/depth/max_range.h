#pragma once

namespace stof::dsp {

// What FusionParams::max_range may be set to, on any command line and in the settings.
inline constexpr int kLeastMaxRangeMm = 500;
inline constexpr int kMostMaxRangeMm = 16'380;

}  // namespace stof::dsp
