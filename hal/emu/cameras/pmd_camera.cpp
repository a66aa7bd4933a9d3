#include "hal/emu/cameras/pmd_camera.h"

#include "dsp/base/check.h"

namespace stof::hal::emu {

PmdCamera::PmdCamera(hal::Clock& clock, Imagery& imagery, const PmdTiming& timing,
                     const FaultPlan& faults)
    : clock_(clock), imagery_(imagery), timing_(timing), sets_(timing.readout, faults) {
  const Size size = imagery.pmd_size();
  STOF_CHECK(size.width > 0 && size.height > 0);
  STOF_CHECK(timing.integration > Duration::zero() && timing.readout >= Duration::zero() &&
             timing.every >= 1);
  samples_.resize(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height) * 4 *
                  Sets::kBuffers);
}

void PmdCamera::on_edge(Time edge) noexcept {
  if (edges_++ % static_cast<std::uint32_t>(timing_.every) != 0) {
    return;
  }
  sets_.on_edge(edge, [&](std::uint32_t number) noexcept {
    Set set{.number = number, .exposures = {}};
    for (int k = 0; k < 4; ++k) {
      set.exposures[static_cast<std::size_t>(k)] = {edge + timing_.integration * k / 4,
                                                    edge + timing_.integration * (k + 1) / 4};
    }
    return set;
  });
}

Result<BorrowedFrame<PmdFrame>> PmdCamera::wait_frame(Time deadline) noexcept {
  return sets_.wait_frame<PmdFrame>(
      clock_, deadline,
      [this](const Sets::Shot& shot, int buffer) noexcept { return fill(shot, buffer); });
}

PmdFrame PmdCamera::fill(const Sets::Shot& shot, int buffer) noexcept {
  const Size size = imagery_.pmd_size();
  const std::ptrdiff_t plane = std::ptrdiff_t{size.width} * size.height;
  PmdFrame frame;
  frame.sequence = shot.first.number;
  for (int k = 0; k < 4; ++k) {
    const std::size_t index = static_cast<std::size_t>(k);
    const Set& set = k < 2 ? shot.first : shot.second;
    const dsp::ImageView<std::uint16_t> out(samples_.data() + plane * (4 * buffer + k), size.width,
                                            size.height);
    imagery_.pmd(set.number, k, out);
    frame.samples[index] = out;
    frame.exposures[index] = set.exposures[index];
  }
  return frame;
}

}  // namespace stof::hal::emu
