#include "hal/emu/stereo_camera.h"

#include <algorithm>

#include "dsp/base/check.h"

namespace stof::hal::emu {

StereoCamera::StereoCamera(hal::Clock& clock, Imagery& imagery, const StereoTiming& timing,
                           const FaultPlan& faults)
    : clock_(clock), imagery_(imagery), timing_(timing), faults_(faults) {
  const Size size = imagery.stereo_size();
  STOF_CHECK(size.width > 0 && size.height > 0);
  STOF_CHECK(timing.exposure > Duration::zero() && timing.readout >= Duration::zero());
  pixels_.resize(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height) * 2 *
                 kCameraSlots);
}

void StereoCamera::on_edge(Time edge) noexcept {
  const Fault fault = faults_.at(edges_++);
  gone_ = fault.kind == FaultKind::kVanish;
  if (gone_) {
    queue_.drop_waiting();
    return;
  }
  if (last_made_.number != 0 && edge < last_made_.exposure.end) {
    return;
  }
  const View before = last_made_;
  last_made_ = {before.number + 1, {edge, edge + timing_.exposure}};
  Shot shot{.left = last_made_,
            .right = last_made_,
            .ready = last_made_.exposure.end + timing_.readout,
            .corrupt = fault.kind == FaultKind::kCorrupt};
  switch (fault.kind) {
    case FaultKind::kDrop:
      return;
    case FaultKind::kRepeat:
      if (!last_arrived_) {
        return;
      }
      shot.left = last_arrived_->left;
      shot.right = last_arrived_->right;
      break;
    case FaultKind::kDelay:
      shot.ready += fault.duration;
      break;
    case FaultKind::kTear:
      shot.right = before;
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

Result<Lease<StereoFrame>> StereoCamera::wait_frame(Time deadline) noexcept {
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
  const StereoFrame frame = fill(shot, slot);
  clock_.wait_until(shot.ready);
  return Lease<StereoFrame>(frame, *this, slot);
}

void StereoCamera::give_back(int slot) noexcept { queue_.release(slot); }

StereoFrame StereoCamera::fill(const Shot& shot, int slot) noexcept {
  const Size size = imagery_.stereo_size();
  const std::ptrdiff_t view = std::ptrdiff_t{size.width} * size.height;
  std::uint8_t* const at = pixels_.data() + 2 * view * slot;
  const dsp::ImageView<std::uint8_t> left(at, size.width, size.height);
  const dsp::ImageView<std::uint8_t> right(at + view, size.width, size.height);
  imagery_.left(shot.left.number, left);
  imagery_.right(shot.right.number, right);
  return {.left = left,
          .right = right,
          .left_exposure = shot.left.exposure,
          .right_exposure = shot.right.exposure,
          .left_sequence = shot.left.number,
          .right_sequence = shot.right.number};
}

}  // namespace stof::hal::emu
