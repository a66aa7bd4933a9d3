#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "host/calibrate/rig/live/view_guide.h"
#include "host/cli/live/raw_feed.h"

// What `stof calib stereo --live --json` prints, an object a line: docs/CALIBRATION.md.
namespace stof::host {

// state: "subscribing", "reading" (views that were kept), "missing" (what still is), "calibrating",
// "calibrated"; "looking" is look_json()'s.
nlohmann::ordered_json stage_json(const char* state, const std::string& text);

// One exposure, as it was judged.
struct LiveLook {
  const RawShot& shot;
  const PairView& corners;
  const ViewJudgement& judgement;
  const ViewGuide& guide;  // with the view, where it was taken
  std::string text;        // what to do, or what became of it
};
// picture_width: of both pictures, px, which are made smaller by a whole number to have no more; 0:
// none is told.
nlohmann::ordered_json look_json(const LiveLook& look, int picture_width);

// The mean of blocks of `by` x `by` pixels, what is over at the right and below left out. by: 1 or
// more, and no more than the picture is wide and high.
dataset::Image<std::uint8_t> smaller_picture(const dataset::Image<std::uint8_t>& picture, int by);

}  // namespace stof::host
