#include "host/cli/rig/hold_watch.h"

#include <algorithm>
#include <utility>

#include "host/calibrate/rig/live/picture_motion.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr double kMovedOnPx = 8;  // since a view, before the next one is looked for

}  // namespace

std::optional<HeldView> HoldWatch::add(RawShot shot) {
  if (taken_ && !moved_on(shot.left)) {
    tell(State::kTaken, "taken: turn it, or the rig, to another tilt");
    return std::nullopt;
  }
  taken_.reset();
  const std::optional<double> motion =
      held_ ? picture_motion(before_, shot.left) : std::optional<double>();
  const bool still = motion && *motion <= most_motion_px_;
  before_ = shot.left;
  if (!still) {
    tell(State::kMoving, motion
                             ? printed("hold still: the picture moves by %.1f px, %.1f are allowed",
                                       *motion, most_motion_px_)
                             : "hold still: the picture moves, or shows too little");
    held_.emplace(HeldView{.first = std::move(shot), .samples = {}});
    held_->samples.push_back(std::move(held_->first.pmd));
    return std::nullopt;
  }
  held_->samples.push_back(std::move(shot.pmd));
  tell(State::kStill, printed("still: hold on for %zu exposures more",
                              exposures_ - std::min(exposures_, held_->samples.size())));
  if (held_->samples.size() < exposures_) {
    return std::nullopt;
  }
  taken_ = held_->first.left;
  return std::exchange(held_, std::nullopt);
}

void HoldWatch::tell(State state, std::string hint) {
  state_ = state;
  hint_ = std::move(hint);
}

bool HoldWatch::moved_on(const dataset::Image<std::uint8_t>& now) const {
  const std::optional<double> motion = picture_motion(*taken_, now);
  return !motion || *motion > kMovedOnPx;
}

}  // namespace stof::host
