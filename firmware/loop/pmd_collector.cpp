#include "firmware/loop/pmd_collector.h"

#include <algorithm>
#include <span>
#include <utility>

namespace stof::firmware {

PmdCollector::PmdCollector(board::Board& board, const Setup& setup, LoopConditions& conditions,
                           const DeviceLending* lending) noexcept
    : board_(board),
      conditions_(conditions),
      lending_(lending),
      pairing_(setup.calibration.pmd.lens.width, setup.calibration.pmd.lens.height),
      samples_(setup.calibration.pmd.under_lsb, setup.calibration.pmd.saturation_lsb),
      light_(setup.calibration.pmd),
      absence_{.why = Absence::Why::kSilent} {}

void PmdCollector::recalibrate(const Setup& setup) noexcept {
  samples_ = {setup.calibration.pmd.under_lsb, setup.calibration.pmd.saturation_lsb};
  light_ = LightGuard(setup.calibration.pmd);
}

Status PmdCollector::next(hal::Time deadline, std::optional<Borrowed>& frame) noexcept {
  Result<Borrowed> taken = usable() ? board_.pmd->wait_frame(deadline) : fail(Status::kDeviceLost);
  if (taken) {
    frame.emplace(std::move(*taken));
    return Status::kOk;
  }
  if (taken.error() == Status::kDeviceLost) {
    pairing_.forget();
  }
  return taken.error();
}

Status PmdCollector::collect(hal::Time edge, hal::Time deadline,
                             const board::TimingConfig& timing) noexcept {
  remember_edge(edge, timing);
  Status last = Status::kTimeout;
  if (!usable() && !conditions_.lost(Component::kPmd)) {
    return last;  // opened again because it repeats itself, which absence_ says
  }
  // What it said of a frame holds until one should have followed.
  if (quiet_edges_++ >= timing.pmd_every) {
    absence_ = {.why = Absence::Why::kSilent};
  }
  for (int i = 0; board_.pmd != nullptr && i < kMaxFramesPerEdge; ++i) {
    // With data that will do there is nothing to wait for, but something newer may be there.
    const bool enough = serves(edge, timing);
    if (enough && timing.pmd_every == 1) {
      return Status::kOk;
    }
    std::optional<Borrowed> frame;
    const Status status = next(enough ? board_.clock.now() : deadline, frame);
    if (enough && status == Status::kTimeout) {
      return Status::kOk;
    }
    conditions_.note_device_status(Component::kPmd, status);
    if (frame) {
      quiet_edges_ = 0;
      take(std::move(*frame));
      continue;
    }
    last = status;
    if (status != Status::kCorrupt) {
      return status;
    }
  }
  return last;
}

PmdVerdict PmdCollector::judge(const hal::PmdFrame& frame) noexcept {
  absence_.why = pairing_.repeating(frame) ? Absence::Why::kFrozen : Absence::Why::kSilent;
  PmdVerdict verdict = pairing_.judge(std::span(windows_).first(window_count_), frame);
  if (verdict.drop != Drop::kNone) {
    return verdict;
  }
  if (!board_.recorded && samples_.repeats(frame.samples)) {
    verdict.drop = Drop::kStale;
    absence_.why = Absence::Why::kFrozen;
  } else if (!light_.is_lit(frame)) {
    verdict.drop = Drop::kDark;
    absence_.why = Absence::Why::kDark;
  }
  return verdict;
}

void PmdCollector::take(Borrowed&& frame) noexcept {
  const PmdVerdict verdict = judge(*frame);
  if (verdict.drop != Drop::kNone) {
    ++of(conditions_.counters().pmd_dropped, verdict.drop);
    return;
  }
  edge_ = windows_[static_cast<std::size_t>(verdict.age)].edge;
  exposed_ = hal::Exposure{frame->exposures.front().begin, frame->exposures.back().end}.middle();
  new_.emplace(std::move(frame));
}

bool PmdCollector::serves(hal::Time edge, const board::TimingConfig& timing) const noexcept {
  const hal::Duration oldest = (2 * timing.pmd_every - 2) * timing.period + timing.period / 4;
  return edge_ && edge - *edge_ <= oldest;
}

std::optional<PmdCollector::Borrowed> PmdCollector::take_new() noexcept {
  std::optional<Borrowed> taken = std::move(new_);
  new_.reset();
  return taken;
}

void PmdCollector::forget() noexcept {
  new_.reset();
  edge_.reset();
  exposed_.reset();
}

void PmdCollector::remember_edge(hal::Time edge, const board::TimingConfig& timing) noexcept {
  std::ranges::copy_backward(windows_.begin(), windows_.end() - 1, windows_.end());
  windows_[0] = {edge, timing.pmd_integration, timing.edge_tolerance};
  const std::size_t reach = static_cast<std::size_t>(2 * timing.pmd_every - 1);
  window_count_ = std::min(window_count_ + 1, reach);
}

}  // namespace stof::firmware
