#include "host/client/session/frame_pace.h"

#include <algorithm>

namespace stof::client {

void FramePace::note(Time arrived) noexcept {
  if (newest_) {
    gaps_[noted_++ % kGaps] = std::max(arrived - *newest_, Duration(0));
  }
  newest_ = newest_ ? std::max(*newest_, arrived) : arrived;
}

Duration FramePace::believed(Duration told) const noexcept {
  // The longest of some gaps is a period at least, also where frames come in bursts.
  const Duration longest = *std::ranges::max_element(gaps_);
  const Duration most = noted_ == 0 ? kUnproven : longest + longest / 8;
  return std::clamp(told, Duration(0), std::min(most, kLongest));
}

}  // namespace stof::client
