#include "hal/linux/gpio/strobe_log.h"

#include <algorithm>

namespace stof::hal::linux {

void StrobeLog::note_rise(Time at, std::uint64_t number) noexcept {
  rise_ = at;
  rise_number_ = number;
}

void StrobeLog::note_fall(Time at, std::uint64_t number) noexcept {
  if (rise_ && number == rise_number_ + 1 && at > *rise_) {
    exposures_[count_++ % kDepth] = {*rise_, at};
  }
  rise_.reset();
}

std::optional<Exposure> StrobeLog::ended_at(Time stamp) const noexcept {
  const std::size_t known = std::min(count_, kDepth);
  for (std::size_t back = 1; back <= known; ++back) {
    const Exposure& exposure = exposures_[(count_ - back) % kDepth];
    if (exposure.end <= stamp) {
      return exposure;
    }
  }
  return std::nullopt;
}

}  // namespace stof::hal::linux
