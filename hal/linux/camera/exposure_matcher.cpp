#include "hal/linux/camera/exposure_matcher.h"

namespace stof::hal::linux {
namespace {

constexpr std::uint32_t kMostSteps = 32;

}  // namespace

void ExposureMatcher::forget() noexcept {
  last_.reset();
  usual_delay_ = {};
  believed_ = false;
  doubtful_ = 0;
}

// How many exposures later than the last claim; none: too many, or that is not remembered.
std::optional<std::uint32_t> ExposureMatcher::steps_since_last(const Exposure& exposure) noexcept {
  Time at = exposure.begin;
  for (std::uint32_t steps = 0; steps <= kMostSteps; ++steps) {
    if (at <= last_->exposure.begin) {
      return at == last_->exposure.begin ? std::optional(steps) : std::nullopt;
    }
    const std::optional<Exposure> before = exposures_.ended_at(at);
    if (!before) {
      return std::nullopt;
    }
    at = before->begin;
  }
  return std::nullopt;
}

MatchedExposure ExposureMatcher::match(Time stamp, std::uint32_t number) noexcept {
  const MatchedExposure nowhere{.exposure = {stamp, stamp}};
  const std::optional<Exposure> found = exposures_.ended_at(stamp);
  if (!found || stamp - found->end > most_delay_) {
    return nowhere;  // the next one's step tells whether it was counted
  }
  const Duration delay = stamp - found->end;
  bool follows = false;
  if (last_) {
    const std::optional<std::uint32_t> steps = steps_since_last(*found);
    const bool soon = !believed_ || delay <= usual_delay_ + most_delay_ / 4;
    follows = steps && *steps > 0 && *steps == number - last_->number && (doubtful_ == 0 || soon);
  }
  if (!believed_) {
    usual_delay_ = delay;
  }
  last_ = Claim{.exposure = *found, .number = number};
  if (!follows) {
    ++doubtful_;
    return nowhere;
  }
  doubtful_ = 0;
  believed_ = true;
  usual_delay_ += (delay - usual_delay_) / 8;
  return {.exposure = *found, .sure = true};
}

}  // namespace stof::hal::linux
