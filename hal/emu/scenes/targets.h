#pragma once

#include <optional>
#include <string_view>

#include "dsp/calib/calibration.h"
#include "hal/emu/scenes/rig.h"
#include "hal/emu/scenes/scene.h"

// Walls before a camera that looks straight at them, each with one thing that is hard to match.
namespace stof::hal::emu {

// Upright or level bars of one colour at 1.5 m, a textured wall at 5 m behind them. Level ones end
// outside of the picture: along the baseline nothing tells where on them a pixel is.
struct Bars {
  double width_px = 8;  // in the left picture, kLeastBarPx .. kMostBarPx
  bool level = false;
};
inline constexpr double kLeastBarPx = 0.5;
inline constexpr double kMostBarPx = 100;

// A wall at 3 m with upright stripes alone.
struct Stripes {
  double period_px = 8;   // in the left picture, kLeastPeriodPx .. kMostPeriodPx
  double contrast = 0.9;  // the dark ones have the bright ones' albedo (1 - contrast)
};
inline constexpr double kLeastPeriodPx = 2;
inline constexpr double kMostPeriodPx = 200;

// bars:WIDTH_PX,upright or bars:WIDTH_PX,level; stripes:PERIOD_PX or stripes:PERIOD_PX,PERCENT, the
// contrast in percent. None: the name is of another scene, or a number is out of its range.
std::optional<Bars> parse_bars(std::string_view name);
std::optional<Stripes> parse_stripes(std::string_view name);

// lens: of the left camera, which is at the world's origin.
Scene bars_scene(const Bars& bars, const dsp::Pinhole& lens);
Scene stripes_scene(const Stripes& stripes, const dsp::Pinhole& lens);

// corridor_rig(), looking along z from the origin.
Rig target_rig();

}  // namespace stof::hal::emu
