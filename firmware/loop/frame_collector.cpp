#include "firmware/loop/frame_collector.h"

#include <utility>

namespace stof::firmware {

FrameCollector::FrameCollector(board::Board& board, const Setup& setup, LoopConditions& conditions,
                               const DeviceLending* lending) noexcept
    : board_(board),
      conditions_(conditions),
      stereo_(board, setup, conditions, lending),
      pmd_(board, setup, conditions, lending),
      both_required_(setup.require_both) {}

Collected FrameCollector::collect(hal::Time edge, hal::Time deadline,
                                  const board::TimingConfig& timing,
                                  Pipeline* search_first) noexcept {
  std::optional<StereoCollector::Borrowed> stereo;
  const Status stereo_status =
      stereo_.collect({edge, timing.stereo_exposure, timing.edge_tolerance}, deadline, stereo);
  if (stereo && search_first != nullptr) {
    search_first->match(**stereo, board_.clock);
  }
  // Also without a stereo frame: what the PMD camera has must not wait for the next edge.
  const Status pmd_status = pmd_.collect(edge, deadline, timing);
  const bool pmd = pmd_.serves(edge, timing);
  conditions_.note_camera(Component::kStereo, stereo ? Absence{} : stereo_.absence());
  if (board_.pmd != nullptr) {
    conditions_.note_camera(Component::kPmd, pmd ? Absence{} : pmd_.absence());
  }
  Collected collected{
      .shot = std::nullopt,
      .lost = stereo_status == Status::kDeviceLost || pmd_status == Status::kDeviceLost};
  if (gives_shot(stereo.has_value(), pmd)) {
    collected.shot.emplace(make_shot(edge, std::move(stereo), pmd));
    conditions_.note_frame(collected.shot->sensors());
  } else {
    if (search_first != nullptr) {
      search_first->forget_match();
    }
    of(conditions_.counters().stereo_dropped, Drop::kUnpartnered) += stereo ? 1U : 0U;
    if (both_required_ || !pmd) {  // else it is not the PMD camera's turn
      conditions_.note_no_frame(stereo ? Component::kPmd : Component::kStereo,
                                stereo ? pmd_status : stereo_status);
    }
  }
  if (timing.pmd_every == 1 && pmd_.take_new()) {  // serves no other edge
    ++of(conditions_.counters().pmd_dropped, Drop::kUnpartnered);
  }
  return collected;
}

void FrameCollector::expect_anew(board::Device camera) noexcept {
  if (camera == board::Device::kStereo) {
    stereo_.expect_anew();
  } else if (camera == board::Device::kPmd) {
    pmd_.expect_anew();
  }
}

bool FrameCollector::gives_shot(bool stereo, bool pmd) const noexcept {
  if (both_required_) {
    return stereo && (pmd || board_.pmd == nullptr);
  }
  return stereo || (pmd && pmd_.holds_new() && *pmd_.exposed() > last_exposed_);
}

Shot FrameCollector::make_shot(hal::Time edge, std::optional<StereoCollector::Borrowed>&& stereo,
                               bool with_pmd) noexcept {
  ++freshness_;
  last_exposed_ = stereo ? (*stereo)->left_exposure.middle() : *pmd_.exposed();
  return {.edge = edge,
          .exposed = last_exposed_,
          .stereo = std::move(stereo),
          .pmd = with_pmd ? pmd_.take_new() : std::nullopt,
          .pmd_exposed = with_pmd ? pmd_.exposed() : std::nullopt,
          .freshness = freshness_,
          .missed_edges = conditions_.edges_without_frame(),
          .stereo_losses = of(conditions_.counters().losses, Component::kStereo)};
}

}  // namespace stof::firmware
