#include "host/client/session/frame_pace.h"

#include <algorithm>
#include <utility>

namespace stof::client {
namespace {

constexpr Duration kSecond = std::chrono::seconds(1);
constexpr std::size_t kEnoughGaps = 8;  // to know how far apart frames come

}  // namespace

void FramePace::note(Time arrived, const std::optional<MadeWith>& made) noexcept {
  if (newest_) {
    const Duration gap = std::max(arrived - *newest_, Duration(0));
    came_ += std::min(gap, kSecond);
    if (!interrupted_) {
      gaps_[noted_++ % kGaps] = gap;
    }
  }
  interrupted_ = false;
  newest_ = newest_ ? std::max(*newest_, arrived) : arrived;
  if (made) {
    change_to(*made);
    if (!frames_tell_ && made->period > Duration(0)) {
      current_.seconds = {};  // messages, which anybody may have sent
      former_.seconds = {};
    }
    frames_tell_ = made->period > Duration(0);
    newest_told_ = newest_told_ > Duration(0) ? newest_told_ : made->period;
    take(made->period, current_);
  }
}

void FramePace::change_to(const MadeWith& made) noexcept {
  if (!current_.made) {
    current_.made = made;
  } else if (current_.made != made) {
    std::swap(current_, former_);
    if (current_.made != made) {
      current_ = Told{.made = made, .seconds = {}};
    }
  }
}

void FramePace::tell(Duration period) noexcept {
  if (period <= Duration(0)) {
    return;
  }
  newest_told_ = period;
  if (!frames_tell_) {
    take(period, current_);
    take(period, former_);  // the newest frame may be somebody else's
  }
}

void FramePace::take(Duration period, Told& told_of) noexcept {
  if (period <= Duration(0)) {
    return;
  }
  const Duration told = std::max(period, least());
  Second& now = told_of.seconds[static_cast<std::size_t>(second()) % kSeconds];
  now.least = now.number == second() ? std::min(now.least, told) : told;
  now.number = second();
}

// Three quarters of the gap that as many exceed as not.
Duration FramePace::least() const noexcept {
  if (noted_ < kEnoughGaps) {
    return Duration(0);
  }
  std::array<Duration, kGaps> gaps = gaps_;
  const auto known = static_cast<std::ptrdiff_t>(std::min(noted_, kGaps));
  std::nth_element(gaps.begin(), gaps.begin() + known / 2, gaps.begin() + known);
  const Duration middle = gaps[static_cast<std::size_t>(known / 2)];
  return middle - middle / 4;
}

Duration FramePace::believed() const noexcept {
  std::optional<Duration> told;
  for (const Second& one : current_.seconds) {
    if (one.number >= 0 && second() - one.number < static_cast<std::int64_t>(kSeconds)) {
      told = std::min(told.value_or(one.least), one.least);
    }
  }
  // The longest of some gaps is a period at least, also where frames come in bursts.
  const Duration longest = *std::ranges::max_element(gaps_);
  const Duration most = noted_ == 0 ? kUnproven : longest + longest / 8;
  if (newest_told_ == Duration(0)) {
    return Duration(0);
  }
  return std::min({told.value_or(std::max(newest_told_, least())), most, kLongestPeriod});
}

}  // namespace stof::client
