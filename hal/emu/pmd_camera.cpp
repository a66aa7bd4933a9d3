#include "hal/emu/pmd_camera.h"

#include <algorithm>

#include "dsp/base/check.h"

namespace stof::hal::emu {

PmdCamera::PmdCamera(hal::Clock& clock, Imagery& imagery, const PmdTiming& timing,
                     const FaultPlan& faults)
    : clock_(clock), imagery_(imagery), timing_(timing), faults_(faults) {
  const Size size = imagery.pmd_size();
  STOF_CHECK(size.width > 0 && size.height > 0);
  STOF_CHECK(timing.integration > Duration::zero() && timing.readout >= Duration::zero() &&
             timing.every >= 1);
  samples_.resize(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height) * 4 *
                  kCameraSlots);
}

void PmdCamera::on_edge(Time edge) noexcept {
  if (edges_++ % static_cast<std::uint32_t>(timing_.every) != 0) {
    return;
  }
  const Fault fault = faults_.at(calls_++);
  gone_ = fault.kind == FaultKind::kVanish;
  if (gone_) {
    queue_.drop_waiting();
    return;
  }
  if (last_made_.number != 0 && edge < last_made_.exposures.back().end) {
    return;
  }
  const Set before = last_made_;
  last_made_.number = before.number + 1;
  for (int k = 0; k < 4; ++k) {
    last_made_.exposures[static_cast<std::size_t>(k)] = {edge + timing_.integration * k / 4,
                                                         edge + timing_.integration * (k + 1) / 4};
  }
  Shot shot{.set = last_made_,
            .second = last_made_,
            .ready = edge + timing_.integration + timing_.readout,
            .corrupt = fault.kind == FaultKind::kCorrupt};
  switch (fault.kind) {
    case FaultKind::kDrop:
      return;
    case FaultKind::kRepeat:
      if (!last_arrived_) {
        return;
      }
      shot.set = last_arrived_->set;
      shot.second = last_arrived_->second;
      break;
    case FaultKind::kDelay:
      shot.ready += fault.duration;
      break;
    case FaultKind::kTear:
      shot.second = before;
      break;
    case FaultKind::kNone:
    case FaultKind::kCorrupt:
    case FaultKind::kVanish:
      break;
  }
  if (!shot.corrupt) {
    last_arrived_ = shot;
  }
  queue_.push(shot);
}

Result<Lease<PmdFrame>> PmdCamera::wait_frame(Time deadline) noexcept {
  if (gone_) {
    return fail(Status::kDeviceLost);
  }
  const Shot* const oldest = queue_.oldest();
  if (oldest == nullptr || oldest->ready > std::max(deadline, clock_.now())) {
    clock_.wait_until(deadline);
    return fail(Status::kTimeout);
  }
  const Shot shot = *oldest;
  const int slot = queue_.take();
  if (shot.corrupt) {
    clock_.wait_until(shot.ready);
    queue_.release(slot);
    return fail(Status::kCorrupt);
  }
  const PmdFrame frame = fill(shot, slot);
  clock_.wait_until(shot.ready);
  return Lease<PmdFrame>(frame, *this, slot);
}

void PmdCamera::give_back(int slot) noexcept { queue_.release(slot); }

PmdFrame PmdCamera::fill(const Shot& shot, int slot) noexcept {
  const Size size = imagery_.pmd_size();
  const std::ptrdiff_t plane = std::ptrdiff_t{size.width} * size.height;
  PmdFrame frame;
  frame.sequence = shot.set.number;
  for (int k = 0; k < 4; ++k) {
    const std::size_t index = static_cast<std::size_t>(k);
    const Set& set = k < 2 ? shot.set : shot.second;
    const dsp::ImageView<std::uint16_t> out(samples_.data() + plane * (4 * slot + k), size.width,
                                            size.height);
    imagery_.pmd(set.number, k, out);
    frame.samples[index] = out;
    frame.exposures[index] = set.exposures[index];
  }
  return frame;
}

}  // namespace stof::hal::emu
