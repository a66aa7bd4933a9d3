#pragma once

#include <cstdint>

#include "board/timing.h"
#include "hal/time.h"

namespace stof::firmware {

// A cost that counts at once where it is more than before, by and by where it is less.
constexpr void decay_peak(hal::Duration& peak, hal::Duration now) noexcept {
  peak = now > peak ? now : peak - (peak - now) / 16;
}

// When trigger edges are due, and whether a frame goes out before the edge that follows its own.
//
// Edges lie on a fixed grid, the first at once. A loop that comes later than an eighth of a period
// skips to the next point of the grid, and no edge follows another sooner than 7/8 of a period.
// A frame goes out in the period of its own edge where the last frames were cheap enough for that
// (from then on; one edge may be left out between both ways); where it fails several times, it is
// tried again after two seconds, then after twice as long each time, a minute at most. Knows no
// clock: `now` is the caller's.
class Schedule {
 public:
  // board::problem(timing) must be empty.
  Schedule(const board::TimingConfig& timing, bool has_pmd, hal::Time start) noexcept;

  // After a pause, perhaps with another timing: the grid begins anew, at `now` at the earliest, a
  // period after the last edge at the latest, and nothing is known about what frames cost.
  void restart(const board::TimingConfig& timing, hal::Time now) noexcept;

  const board::TimingConfig& timing() const noexcept { return timing_; }
  // The next edge; until then frames of the edge before it may come.
  hal::Time next() const noexcept { return next_; }
  // Frames of `edge` that have not come by then will not come: the next edge, or some time before
  // it where the period is long.
  hal::Time frame_deadline(hal::Time edge) const noexcept;
  // The last packet leaves by then: well before the next edge, for a thread that wakes up late.
  hal::Time send_deadline() const noexcept { return next_ - timing_.period / 8; }
  // Whether frames go out in the period of their own edge.
  bool same_period() const noexcept { return same_period_; }
  // A frame of that edge is too old to be sent.
  bool expired(hal::Time edge, hal::Time now) const noexcept;

  // The next edge is due then: it is one of a recording.
  void follow(hal::Time next) noexcept { next_ = next; }

  // Frames of these two edges, with none between them, do not follow each other: three periods in a
  // row had no frame, which is what LoopConditions takes for more than an incident. Why they had
  // none does not matter, also not that the computer was too slow: what moved meanwhile is unseen.
  bool gap(hal::Time before, hal::Time edge) const noexcept;

  // How late the loop was for an edge.
  struct Lateness {
    std::uint64_t skipped = 0;  // whole periods without an edge
    bool noticeable = false;    // not skipped, but later than the tolerance of edges
  };
  // The loop is ready for the next edge: next() is what it has to wait for.
  Lateness arrive(hal::Time now) noexcept;
  // The edge of next() is driven now; the next one is due a period later. Returns what next() was.
  hal::Time advance() noexcept;
  // An edge went out at that time: skips periods until the next one is far enough from it. How
  // many.
  std::uint64_t keep_distance(hal::Time edge) noexcept;

  // Frames of `edge` were asked for at `begin` and had come at `end`.
  void note_fetch(hal::Time edge, hal::Time begin, hal::Time end) noexcept;

  struct Costs {
    hal::Duration search{};
    hal::Duration other{};     // conversion, fusion, coding, sending, watching
    hal::Duration paced{};     // waits between packets
    bool search_first = true;  // the search need not wait for the PMD camera
  };
  // The frame of `edge` was sent, at `now`.
  void note_sent(hal::Time edge, const Costs& costs, hal::Time now) noexcept;

 private:
  // How long after its edge a frame is out, by what the last ones took.
  hal::Duration expected_latency(bool search_first) const noexcept;

  board::TimingConfig timing_;
  bool has_pmd_;
  hal::Time next_;
  bool same_period_ = false;
  hal::Duration fetch_cost_{};  // of the costlier of the last frames: from the cameras' drivers
  hal::Duration search_cost_{};
  hal::Duration other_cost_{};
  int overruns_ = 0;               // frames that were late for the next edge; each counts for some
  hal::Time retry_at_{};           // same_period_ not before
  hal::Duration retry_backoff_{};  // the last one
};

}  // namespace stof::firmware
