#include "host/client/session/session_tracker.h"

#include <algorithm>

namespace stof::client {
namespace {

constexpr Duration kSilence = std::chrono::seconds(1);

}  // namespace

SessionTracker::Verdict SessionTracker::judge(const wire::Origin& origin, Time now) {
  if (device_id_ && *device_id_ != origin.device_id) {
    return Verdict::kForeign;
  }
  Verdict verdict = Verdict::kCurrent;
  if (!current_ || current_->session_id != origin.session_id) {
    const auto end =
        retired_.begin() + static_cast<std::ptrdiff_t>(std::min(retired_count_, retired_.size()));
    const bool ended = std::find(retired_.begin(), end, origin.session_id) != end;
    if (ended && now - last_heard_ < kSilence) {
      return Verdict::kForeign;
    }
    if (current_) {
      retired_[retired_count_++ % kRetired] = current_->session_id;
    }
    device_id_ = origin.device_id;
    current_ = origin;
    verdict = Verdict::kStarted;
  }
  last_heard_ = now;
  return verdict;
}

}  // namespace stof::client
