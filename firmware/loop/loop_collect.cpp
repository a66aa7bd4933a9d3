#include <algorithm>
#include <utility>

#include "firmware/loop/loop.h"

// What of the cameras' frames belongs to an edge.
namespace stof::firmware {
namespace {

// A camera that answers at once with frames of other edges is drained by so many a period.
constexpr int kMaxFramesPerEdge = 16;

}  // namespace

Status Loop::collect(hal::Time edge) noexcept {
  remember(edge);
  const hal::Time start = board_.clock.now();
  std::optional<StereoLease> stereo;
  const Status stereo_status = collect_stereo(edge, stereo);
  if (prompt_ && stereo && pipeline_.may_match_first()) {
    pipeline_.match(**stereo);  // while the PMD camera integrates
  }
  // Also without a stereo frame: what the PMD camera has must not wait for the next edge.
  const Status pmd_status = board_.pmd == nullptr ? Status::kOk : collect_pmd(edge);
  const bool pmd_good = board_.pmd == nullptr || pmd_usable(edge);
  if (start - edge > std::max(timing_.stereo_exposure, timing_.pmd_integration)) {
    follow(fetch_cost_, board_.clock.now() - start);  // all of it waited already
  }
  if (stereo && pmd_good) {
    hold(edge, std::move(*stereo));
    paired(true, Part::kLoop, Status::kOk);
  } else {
    pipeline_.forget_match();
    of(events_.counters.stereo_dropped, Drop::kUnpartnered) += stereo ? 1U : 0U;
    paired(false, stereo ? Part::kPmd : Part::kStereo, stereo ? pmd_status : stereo_status);
  }
  if (pmd_ && timing_.pmd_every == 1) {  // serves no other edge
    ++of(events_.counters.pmd_dropped, Drop::kUnpartnered);
    pmd_.reset();
  }
  return first_lost(stereo_status, pmd_status) == Status::kDeviceLost ? Status::kDeviceLost
                                                                      : Status::kOk;
}

Status Loop::collect_stereo(hal::Time edge, std::optional<StereoLease>& found) noexcept {
  const Window window{edge, timing_.stereo_exposure, timing_.edge_tolerance};
  Status last = Status::kTimeout;
  for (int i = 0; i < kMaxFramesPerEdge; ++i) {
    Result<StereoLease> frame = board_.stereo.wait_frame(next_);
    heard(Part::kStereo, frame ? Status::kOk : frame.error());
    if (!frame) {
      last = frame.error();
      if (last == Status::kCorrupt) {
        continue;  // perhaps one left over: the right one may still come
      }
      return last;
    }
    const Drop drop = stereo_pairing_.judge(window, **frame);
    if (drop == Drop::kNone) {
      found.emplace(std::move(*frame));
      return Status::kOk;
    }
    ++of(events_.counters.stereo_dropped, drop);
  }
  return last;
}

Status Loop::collect_pmd(hal::Time edge) noexcept {
  Status last = Status::kTimeout;
  for (int i = 0; i < kMaxFramesPerEdge; ++i) {
    // With data that will do there is nothing to wait for, but something newer may be there.
    const bool enough = pmd_usable(edge);
    if (enough && timing_.pmd_every == 1) {
      return Status::kOk;
    }
    Result<PmdLease> frame = board_.pmd->wait_frame(enough ? board_.clock.now() : next_);
    if (enough && !frame && frame.error() == Status::kTimeout) {
      return Status::kOk;
    }
    heard(Part::kPmd, frame ? Status::kOk : frame.error());
    if (!frame) {
      last = frame.error();
      if (last == Status::kCorrupt) {
        continue;
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
      ++of(events_.counters.pmd_dropped, verdict.drop);
    }
  }
  return last;
}

bool Loop::pmd_usable(hal::Time edge) const noexcept {
  const hal::Duration oldest = (2 * timing_.pmd_every - 2) * timing_.period + timing_.period / 4;
  return pmd_edge_ && edge - *pmd_edge_ <= oldest;
}

void Loop::hold(hal::Time edge, StereoLease&& stereo) noexcept {
  ++freshness_;
  const hal::Time exposed = stereo->left_exposure.middle();
  held_.emplace(Shot{edge, exposed, std::move(stereo), std::move(pmd_), pmd_exposed_, freshness_,
                     silent_edges_});
  pmd_.reset();
}

void Loop::remember(hal::Time edge) noexcept {
  std::ranges::copy_backward(pmd_windows_.begin(), pmd_windows_.end() - 1, pmd_windows_.end());
  pmd_windows_[0] = {edge, timing_.pmd_integration, timing_.edge_tolerance};
  const std::size_t reach = static_cast<std::size_t>(2 * timing_.pmd_every - 1);
  pmd_window_count_ = std::min(pmd_window_count_ + 1, reach);
}

}  // namespace stof::firmware
