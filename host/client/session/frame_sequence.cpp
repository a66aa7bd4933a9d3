#include "host/client/session/frame_sequence.h"

#include <algorithm>

namespace stof::client {
namespace {

constexpr std::int32_t kSlack = 128;
constexpr int kConvincing = 2;  // advances of a trail
constexpr int kPassedFrames = 3;
// Whichever is longer: also where frames are slow.
constexpr Duration kPassedWithin = std::chrono::seconds(5);
constexpr std::int32_t kPassedWithinFrames = 8;

// Whether a counter that was `before` at `then` may be `value` at `now`.
bool reachable(std::uint32_t value, std::uint32_t before, Time then, Time now) noexcept {
  constexpr std::int64_t kMost = std::int64_t{1} << 30;
  const std::int64_t elapsed_ms = now <= then ? 0 : (now - then) / std::chrono::milliseconds(1);
  return number_distance(value, before) <= kSlack + std::min(elapsed_ms, kMost);
}

}  // namespace

FrameSequence::Verdict FrameSequence::judge(const wire::FrameStamp& stamp, Time arrived) noexcept {
  fresh_at_ = fresh_at_.value_or(arrived);
  follow(stamp);
  const bool jumps = !plausible(stamp.number, arrived) ||
                     (freshness_ && !reachable(stamp.freshness, *freshness_, *fresh_at_, arrived));
  const bool closed = over(stamp.number);
  if (!jumps && !closed && fresh(stamp.freshness)) {
    return Verdict::kBelieved;
  }
  if (arrived - *fresh_at_ >= kPatience && trail_->advances >= kConvincing) {
    *this = {};
    freshness_ = stamp.freshness - 1;
    fresh_at_ = arrived;
    return Verdict::kResynchronised;
  }
  if (jumps) {
    return Verdict::kImplausible;
  }
  if (!closed) {
    return Verdict::kBelieved;
  }
  return passed_over(stamp.number, arrived) ? Verdict::kPassedOver : Verdict::kOver;
}

bool FrameSequence::plausible(std::uint32_t number, Time arrived) const noexcept {
  return !newest_ || reachable(number, *newest_, newest_at_, arrived);
}

bool FrameSequence::ahead(std::uint32_t number) const noexcept {
  return newest_ && number_distance(number, *newest_) > 0;
}

// Two frames are in flight: with n seen, n - 1 may still begin.
bool FrameSequence::over(std::uint32_t number) const noexcept {
  return (closed_ && number_distance(number, *closed_) <= 0) ||
         (newest_ && number_distance(number, *newest_) < -1);
}

bool FrameSequence::passed_over(std::uint32_t number, Time arrived) noexcept {
  const std::size_t at = number % kRemembered;
  if (newest_ && *newest_ - number < kRemembered &&
      (begun_.test(at) || arrived - passed_at_[at] < kSpread)) {
    return false;
  }
  if (!passed_ || (arrived - passed_->since >= kPassedWithin &&
                   number_distance(number, passed_->first) > kPassedWithinFrames)) {
    passed_ = {.first = number, .number = number, .since = arrived, .frames = 1};
  } else if (number_distance(number, passed_->number) > 0) {
    passed_->number = number;
    ++passed_->frames;
  }
  return passed_->frames >= kPassedFrames;
}

// The first verified exposure is number 1.
bool FrameSequence::fresh(std::uint32_t freshness) const noexcept {
  return freshness_ ? number_distance(freshness, *freshness_) > 0 : freshness != 0;
}

void FrameSequence::follow(const wire::FrameStamp& stamp) noexcept {
  const std::int32_t ahead = trail_ ? number_distance(stamp.number, trail_->number) : kSlack + 1;
  if (ahead > kSlack || ahead < -kSlack) {
    trail_ = {.number = stamp.number, .freshness = stamp.freshness};
  } else if (ahead > 0) {
    const std::int32_t fresher = number_distance(stamp.freshness, trail_->freshness);
    trail_->advances += fresher > 0 && fresher <= kSlack ? 1 : 0;
    trail_->number = stamp.number;
    trail_->freshness = stamp.freshness;
  }
}

bool FrameSequence::begin(std::uint32_t number, Time arrived) noexcept {
  if (newest_ && number_distance(number, *newest_) <= 0) {
    begun_.set(number % kRemembered);
    return false;
  }
  if (!newest_ || number - *newest_ >= kRemembered) {
    begun_ = newest_ ? std::bitset<kRemembered>() : ~std::bitset<kRemembered>();  // nobody listened
    passed_at_.fill(arrived);
  } else {
    for (std::uint32_t skipped = *newest_ + 1; skipped != number; ++skipped) {
      begun_.reset(skipped % kRemembered);
      passed_at_[skipped % kRemembered] = arrived;
    }
  }
  begun_.set(number % kRemembered);
  newest_ = number;
  newest_at_ = arrived;
  return true;
}

std::uint32_t FrameSequence::close(std::uint32_t number) noexcept {
  const std::uint32_t skipped = closed_ ? number - *closed_ - 1 : 0;
  closed_ = number;
  return skipped;
}

bool FrameSequence::advance(std::uint32_t freshness, Time arrived) noexcept {
  if (!fresh(freshness)) {
    return false;
  }
  freshness_ = freshness;
  fresh_at_ = arrived;
  trail_.reset();
  return true;
}

}  // namespace stof::client
