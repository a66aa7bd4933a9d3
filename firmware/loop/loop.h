#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "board/board.h"
#include "board/config.h"
#include "dsp/base/status.h"
#include "firmware/events/events.h"
#include "firmware/loop/pairing.h"
#include "firmware/pipeline/pipeline.h"
#include "firmware/pipeline/shot.h"
#include "firmware/pipeline/stream.h"

namespace stof::firmware {

// The PMD camera may expose at every k-th edge, k at most this.
inline constexpr int kMaxPmdEvery = 8;

// kDeviceLost, where it is one of them, else b.
constexpr Status first_lost(Status a, Status b) noexcept {
  return a == Status::kDeviceLost ? a : b;
}

// A cost that counts at once where it is more than before, by and by where it is less.
constexpr void follow(hal::Duration& cost, hal::Duration now) noexcept {
  cost = std::max(now, cost - (cost - now) / 16);
}

// Empty, or why edges of this timing cannot be told apart or cameras cannot follow.
const char* problem(const board::TimingConfig& timing) noexcept;

// The one loop. Where a frame can be computed before the next edge, it pulses the trigger for n,
// searches while the PMD camera still integrates, collects, fuses and publishes n: the last packet
// leaves before the next edge. Where the computer is too slow for that, it pulses for n + 1,
// computes and publishes n, and collects n + 1: a period later, at the same rate. What the
// last frames have cost says when that is worth trying; where it fails several times, it is tried
// again after a while, then after a longer one.
//
// Edges lie on a fixed grid, the first at once. A loop that comes later than an eighth of a period
// skips to the next point of the grid, and no edge follows another sooner than 7/8 of a period.
// With a PMD camera at every k-th edge, k > 1, frames of the edges between use the last PMD data,
// which are at most 2 k - 2 periods old: an integration may take k periods. Allocates nothing.
class Loop {
 public:
  // problem(timing) must be empty; pipeline was built for frames of the setup's sizes.
  Loop(board::Board& board, const board::TimingConfig& timing, const Setup& setup,
       Pipeline& pipeline, Stream& stream, Events& events) noexcept;

  // One period. Blocks until the next point of the grid, and there computes and publishes.
  // kOk: whether or not there was a frame. kDeviceLost: a device has to be reopened; calling on is
  // allowed, and needed by devices that come back by themselves.
  Status step() noexcept;

  // After a pause, with another timing perhaps; problem(timing) must be empty. The grid begins
  // anew, and nothing is known about what frames will cost.
  void restart(const board::TimingConfig& timing) noexcept;

 private:
  static constexpr std::size_t kHistory = 2 * kMaxPmdEvery - 1;
  using StereoLease = hal::Lease<hal::StereoFrame>;
  using PmdLease = hal::Lease<hal::PmdFrame>;

  void wait_for_grid() noexcept;
  Result<hal::Time> pulse() noexcept;
  Status publish_held() noexcept;
  // What this frame cost, and whether the next can be out before its next edge.
  void learn(const Stats& stats, hal::Time edge) noexcept;
  Status collect(hal::Time edge) noexcept;
  Status collect_stereo(hal::Time edge, std::optional<StereoLease>& found) noexcept;
  Status collect_pmd(hal::Time edge) noexcept;
  bool pmd_usable(hal::Time edge) const noexcept;
  void hold(hal::Time edge, StereoLease&& stereo) noexcept;
  void remember(hal::Time edge) noexcept;
  // Counts what a device answered; notes when it is lost, or back.
  void heard(Part part, Status status) noexcept;
  void link_answered(Status status) noexcept;
  void note(const Event& event) noexcept;
  void paired(bool success, Part missing, Status why) noexcept;

  board::Board& board_;
  board::TimingConfig timing_;
  Pipeline& pipeline_;
  Stream& stream_;
  Events& events_;
  StereoPairing stereo_pairing_;
  PmdPairing pmd_pairing_;

  hal::Time next_;                              // the next point of the grid
  std::array<Window, kHistory> pmd_windows_{};  // of the last edges, newest first
  std::size_t pmd_window_count_ = 0;
  std::optional<Shot> held_;
  std::optional<PmdLease> pmd_;        // accepted, and not in a shot yet
  std::optional<hal::Time> pmd_edge_;  // of the last accepted PMD frame
  std::optional<hal::Time> pmd_exposed_;
  std::uint32_t freshness_ = 0;
  std::uint32_t silent_edges_ = 0;  // without a frame, since the last with one
  bool publishing_ = false;
  std::uint32_t edges_in_time_ = 0;  // since the loop was late, as far as that matters
  std::array<bool, kParts> lost_{};
  bool unreachable_ = false;    // no receiver
  bool prompt_ = false;         // frames go out before their next edge
  hal::Duration fetch_cost_{};  // of the costlier of the last frames: from the cameras' drivers
  hal::Duration search_cost_{};
  hal::Duration other_cost_{};  // conversion, fusion, coding, sending, watching
  int overruns_ = 0;            // of late, being prompt: each counts for some frames
  hal::Time prompt_again_{};    // not before, after it has failed
  hal::Duration patience_{};    // until then
};

}  // namespace stof::firmware
