#include "firmware/loop/frame_collector.h"

#include <algorithm>
#include <span>
#include <utility>

namespace stof::firmware {
namespace {

// A camera that answers at once with frames of other edges is drained by so many a period.
constexpr int kMaxFramesPerEdge = 16;

template <typename T>
Status status_of(const Result<T>& result) noexcept {
  return result ? Status::kOk : result.error();
}

}  // namespace

FrameCollector::FrameCollector(board::Board& board, const Setup& setup, LoopConditions& conditions,
                               const DeviceLending* lending) noexcept
    : board_(board),
      conditions_(conditions),
      lending_(lending),
      stereo_pairing_(setup.calibration.stereo.left.width, setup.calibration.stereo.left.height),
      pmd_pairing_(setup.calibration.pmd.lens.width, setup.calibration.pmd.lens.height) {}

Collected FrameCollector::collect(hal::Time edge, hal::Time deadline,
                                  const board::TimingConfig& timing,
                                  Pipeline* search_first) noexcept {
  remember_edge(edge, timing);
  std::optional<BorrowedStereo> stereo;
  const Status stereo_status =
      collect_stereo({edge, timing.stereo_exposure, timing.edge_tolerance}, deadline, stereo);
  if (stereo && search_first != nullptr) {
    search_first->match(**stereo, board_.clock);
  }
  // Also without a stereo frame: what the PMD camera has must not wait for the next edge.
  const Status pmd_status =
      board_.pmd == nullptr ? Status::kOk : collect_pmd(edge, deadline, timing);
  Collected collected{
      .shot = std::nullopt,
      .lost = stereo_status == Status::kDeviceLost || pmd_status == Status::kDeviceLost};
  if (stereo && (board_.pmd == nullptr || pmd_usable(edge, timing))) {
    collected.shot.emplace(make_shot(edge, std::move(*stereo)));
    conditions_.note_frame();
  } else {
    if (search_first != nullptr) {
      search_first->forget_match();
    }
    of(conditions_.counters().stereo_dropped, Drop::kUnpartnered) += stereo ? 1U : 0U;
    conditions_.note_no_frame(stereo ? Component::kPmd : Component::kStereo,
                              stereo ? pmd_status : stereo_status);
  }
  if (pmd_ && timing.pmd_every == 1) {  // serves no other edge
    ++of(conditions_.counters().pmd_dropped, Drop::kUnpartnered);
    pmd_.reset();
  }
  return collected;
}

Status FrameCollector::collect_stereo(const ExposureWindow& window, hal::Time deadline,
                                      std::optional<BorrowedStereo>& found) noexcept {
  Status last = Status::kTimeout;
  for (int i = 0; i < kMaxFramesPerEdge; ++i) {
    Result<BorrowedStereo> frame = usable(board::Device::kStereo)
                                       ? board_.stereo.wait_frame(deadline)
                                       : fail(Status::kDeviceLost);
    conditions_.note_device_status(Component::kStereo, status_of(frame));
    if (!frame) {
      last = frame.error();
      if (last == Status::kCorrupt) {
        continue;  // perhaps one left over: the right one may still come
      }
      if (last == Status::kDeviceLost) {
        stereo_pairing_.forget();
      }
      return last;
    }
    const Drop drop = stereo_pairing_.judge(window, **frame);
    if (drop == Drop::kNone) {
      found.emplace(std::move(*frame));
      return Status::kOk;
    }
    ++of(conditions_.counters().stereo_dropped, drop);
  }
  return last;
}

Status FrameCollector::collect_pmd(hal::Time edge, hal::Time deadline,
                                   const board::TimingConfig& timing) noexcept {
  Status last = Status::kTimeout;
  for (int i = 0; i < kMaxFramesPerEdge; ++i) {
    // With data that will do there is nothing to wait for, but something newer may be there.
    const bool enough = pmd_usable(edge, timing);
    if (enough && timing.pmd_every == 1) {
      return Status::kOk;
    }
    Result<BorrowedPmd> frame = usable(board::Device::kPmd)
                                    ? board_.pmd->wait_frame(enough ? board_.clock.now() : deadline)
                                    : fail(Status::kDeviceLost);
    if (enough && !frame && frame.error() == Status::kTimeout) {
      return Status::kOk;
    }
    conditions_.note_device_status(Component::kPmd, status_of(frame));
    if (!frame) {
      last = frame.error();
      if (last == Status::kCorrupt) {
        continue;
      }
      if (last == Status::kDeviceLost) {
        pmd_pairing_.forget();
      }
      return last;
    }
    const PmdVerdict verdict =
        pmd_pairing_.judge(std::span(pmd_windows_).first(pmd_window_count_), **frame);
    if (verdict.drop == Drop::kNone) {
      pmd_edge_ = pmd_windows_[static_cast<std::size_t>(verdict.age)].edge;
      pmd_exposed_ =
          hal::Exposure{(*frame)->exposures.front().begin, (*frame)->exposures.back().end}.middle();
      pmd_.emplace(std::move(*frame));
    } else {
      ++of(conditions_.counters().pmd_dropped, verdict.drop);
    }
  }
  return last;
}

bool FrameCollector::pmd_usable(hal::Time edge, const board::TimingConfig& timing) const noexcept {
  const hal::Duration oldest = (2 * timing.pmd_every - 2) * timing.period + timing.period / 4;
  return pmd_edge_ && edge - *pmd_edge_ <= oldest;
}

Shot FrameCollector::make_shot(hal::Time edge, BorrowedStereo&& stereo) noexcept {
  ++freshness_;
  const hal::Time exposed = stereo->left_exposure.middle();
  Shot shot{edge,
            exposed,
            std::move(stereo),
            std::move(pmd_),
            pmd_exposed_,
            freshness_,
            conditions_.edges_without_frame(),
            of(conditions_.counters().losses, Component::kStereo)};
  pmd_.reset();
  return shot;
}

void FrameCollector::remember_edge(hal::Time edge, const board::TimingConfig& timing) noexcept {
  std::ranges::copy_backward(pmd_windows_.begin(), pmd_windows_.end() - 1, pmd_windows_.end());
  pmd_windows_[0] = {edge, timing.pmd_integration, timing.edge_tolerance};
  const std::size_t reach = static_cast<std::size_t>(2 * timing.pmd_every - 1);
  pmd_window_count_ = std::min(pmd_window_count_ + 1, reach);
}

}  // namespace stof::firmware
