#include "firmware/loop/schedule.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "dsp/base/check.h"

namespace stof::firmware {
namespace {

// A frame that was late for the next edge is forgotten after so many that were not.
constexpr int kOverrunWeight = 16;
constexpr int kMostOverruns = 3 * kOverrunWeight;
constexpr hal::Duration kLeastBackoff = std::chrono::seconds(2);
constexpr hal::Duration kMostBackoff = std::chrono::minutes(1);
// From the end of an exposure to the frame in hand, of the slowest camera: a board's `most_delay`
// and its driver.
constexpr hal::Duration kFrameDelay = std::chrono::milliseconds(250);
constexpr int kExpiredPeriods = 3;
constexpr int kMostPeriodsApart = 3;

}  // namespace

Schedule::Schedule(const board::TimingConfig& timing, bool has_pmd, hal::Time start) noexcept
    : timing_(timing), has_pmd_(has_pmd), next_(start) {
  STOF_CHECK(*board::problem(timing) == '\0');
}

void Schedule::restart(const board::TimingConfig& timing, hal::Time now) noexcept {
  const hal::Time sooner = next_ - timing_.period + timing.period;
  *this = Schedule(timing, has_pmd_, std::max(std::min(next_, sooner), now));
}

hal::Time Schedule::frame_deadline(hal::Time edge) const noexcept {
  const hal::Duration exposed = std::max(timing_.stereo_exposure, timing_.pmd_integration);
  return std::min(next_, edge + exposed + kFrameDelay);
}

bool Schedule::expired(hal::Time edge, hal::Time now) const noexcept {
  return now - edge > kExpiredPeriods * timing_.period;
}

bool Schedule::gap(hal::Time before, hal::Time edge) const noexcept {
  // Edges leave the grid by less than half a period.
  return edge - before > kMostPeriodsApart * timing_.period + timing_.period / 2;
}

Schedule::Lateness Schedule::arrive(hal::Time now) noexcept {
  const hal::Duration late = now - next_;
  if (late <= timing_.period / 8) {
    return {.noticeable = late > timing_.edge_tolerance};
  }
  const auto skipped = (late + timing_.period - hal::Duration(1)) / timing_.period;
  next_ += skipped * timing_.period;
  return {.skipped = static_cast<std::uint64_t>(skipped)};
}

hal::Time Schedule::advance() noexcept { return std::exchange(next_, next_ + timing_.period); }

std::uint64_t Schedule::keep_distance(hal::Time edge) noexcept {
  std::uint64_t skipped = 0;
  while (next_ - edge < timing_.period - timing_.period / 8) {
    next_ += timing_.period;
    ++skipped;
  }
  return skipped;
}

void Schedule::note_fetch(hal::Time edge, hal::Time begin, hal::Time end) noexcept {
  // Asked for later than this, all frames were there already: nothing of the time was waiting.
  if (begin - edge > std::max(timing_.stereo_exposure, timing_.pmd_integration)) {
    decay_peak(fetch_cost_, end - begin);
  }
}

hal::Duration Schedule::expected_latency(bool search_first) const noexcept {
  const hal::Duration fetched = timing_.stereo_exposure + fetch_cost_;
  const hal::Duration integrated = has_pmd_ ? timing_.pmd_integration : hal::Duration{};
  const hal::Duration searched = search_first ? std::max(fetched + search_cost_, integrated)
                                              : std::max(fetched, integrated) + search_cost_;
  return searched + other_cost_;
}

void Schedule::note_sent(hal::Time edge, const Costs& costs, hal::Time now) noexcept {
  decay_peak(search_cost_, costs.search);
  decay_peak(other_cost_, costs.other);
  if (!same_period_) {
    same_period_ =
        expected_latency(costs.search_first) <= timing_.period * 15 / 16 && now >= retry_at_;
    overruns_ = 0;
    // The edge whose frame is to go out in its own period has already gone, and some of that period
    // went into this frame: where the rest is too short, one edge is left out, and nothing is late.
    if (same_period_ && now + search_cost_ + other_cost_ > next_) {
      next_ += timing_.period;
    }
    return;
  }
  const bool overrun = now - costs.paced - edge > timing_.period;
  overruns_ = overrun ? overruns_ + kOverrunWeight : std::max(0, overruns_ - 1);
  if (overruns_ >= kMostOverruns) {
    same_period_ = false;
    retry_backoff_ = std::clamp(2 * retry_backoff_, kLeastBackoff, kMostBackoff);
    retry_at_ = now + retry_backoff_;
  } else if (now - retry_at_ > kMostBackoff) {
    retry_backoff_ = {};
  }
}

}  // namespace stof::firmware
