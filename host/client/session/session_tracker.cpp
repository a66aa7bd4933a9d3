#include "host/client/session/session_tracker.h"

namespace stof::client {
namespace {

bool same(const wire::Origin& one, const wire::Origin& other) noexcept {
  return one.device_id == other.device_id && one.session_id == other.session_id;
}

}  // namespace

SessionTracker::Verdict SessionTracker::judge(const wire::Origin& origin, bool tells, bool proven,
                                              Time now) {
  const bool told = proven || (expected_ && same(*expected_, origin));
  if (!tells && !told) {
    return current_ && same(*current_, origin) ? Verdict::kCurrent : Verdict::kForeign;
  }
  if (expected_ ? !told : device_id_ && *device_id_ != origin.device_id) {
    refuse(origin, now);
    return Verdict::kForeign;
  }
  Verdict verdict = Verdict::kCurrent;
  if (!current_ || current_->session_id != origin.session_id) {
    if (current_ && !told && now - last_heard_ < kSilence) {
      refuse(origin, now);
      return Verdict::kForeign;
    }
    if (current_) {  // what was refused may have been of this one
      contested_at_.reset();
    }
    outlasts_ = told && told_;
    ended_ = current_ ? std::optional(current_->session_id) : std::nullopt;
    device_id_ = origin.device_id;
    current_ = origin;
    began_ = now;
    verdict = Verdict::kStarted;
  }
  told_ = told;
  last_heard_ = now;
  if (contested_at_ && now - *contested_at_ >= 2 * kTurnedRound) {
    ++contests_;
    contested_at_.reset();
  }
  return verdict;
}

// What a sensor had sent before it started again may arrive after that.
void SessionTracker::refuse(const wire::Origin& origin, Time now) {
  const bool just_ended = ended_ == origin.session_id && now - began_ < kSilence;
  const std::optional<std::uint32_t> device =
      expected_ ? std::optional(expected_->device_id) : device_id_;
  if (!contested_at_ && device == origin.device_id && !just_ended) {
    contested_at_ = now;
  }
}

}  // namespace stof::client
