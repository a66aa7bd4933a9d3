#include "hal/emu/cameras/stereo_camera.h"

#include "dsp/base/check.h"

namespace stof::hal::emu {

StereoCamera::StereoCamera(hal::Clock& clock, Imagery& imagery, const StereoTiming& timing,
                           const FaultPlan& faults, LiveFault* live)
    : clock_(clock), imagery_(imagery), timing_(timing), views_(timing.readout, faults, live) {
  const Size size = imagery.stereo_size();
  STOF_CHECK(size.width > 0 && size.height > 0);
  STOF_CHECK(timing.exposure > Duration::zero() && timing.readout >= Duration::zero());
  pixels_.resize(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height) * 2 *
                 Views::kBuffers);
}

void StereoCamera::on_edge(Time edge) noexcept {
  views_.on_edge(edge, [&](std::uint32_t number) noexcept {
    return View{number, {edge, edge + timing_.exposure}};
  });
}

Result<BorrowedFrame<StereoFrame>> StereoCamera::wait_frame(Time deadline) noexcept {
  return views_.wait_frame<StereoFrame>(
      clock_, deadline,
      [this](const Views::Shot& shot, int buffer) noexcept { return fill(shot, buffer); });
}

StereoFrame StereoCamera::fill(const Views::Shot& shot, int buffer) noexcept {
  const Size size = imagery_.stereo_size();
  const std::ptrdiff_t view = std::ptrdiff_t{size.width} * size.height;
  std::uint8_t* const at = pixels_.data() + 2 * view * buffer;
  const dsp::ImageView<std::uint8_t> left(at, size.width, size.height);
  const dsp::ImageView<std::uint8_t> right(at + view, size.width, size.height);
  imagery_.left(shot.first.number, left);
  imagery_.right(shot.frozen != 0 ? shot.frozen : shot.second.number, right);
  return {.left = left,
          .right = right,
          .left_exposure = shot.first.exposure,
          .right_exposure = shot.second.exposure,
          .left_sequence = shot.first.number,
          .right_sequence = shot.second.number};
}

}  // namespace stof::hal::emu
