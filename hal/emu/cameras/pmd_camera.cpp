#include "hal/emu/cameras/pmd_camera.h"

#include "dsp/base/check.h"
#include "hal/emu/imagery/noise.h"

namespace stof::hal::emu {
namespace {

// Samples without light: the sensor's dark level and the noise of reading it.
void read_dark(std::uint32_t number, int index, dsp::ImageView<std::uint16_t> out) noexcept {
  constexpr int kDarkLevel = 100;
  constexpr int kSigmaBits = 1;  // 2 LSB
  GaussianNoise noise(4 * std::uint64_t{number} + static_cast<std::uint64_t>(index));
  for (int y = 0; y < out.height(); ++y) {
    for (std::uint16_t& value : out.row(y)) {
      value =
          static_cast<std::uint16_t>(kDarkLevel + (noise.next() >> (kGaussianBits - kSigmaBits)));
    }
  }
}

}  // namespace

PmdCamera::PmdCamera(hal::Clock& clock, Imagery& imagery, const PmdTiming& timing,
                     const FaultPlan& faults, LiveFault* live)
    : clock_(clock), imagery_(imagery), timing_(timing), sets_(timing.readout, faults, live) {
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
    if (shot.dark) {
      read_dark(set.number, k, out);
    } else {
      imagery_.pmd(shot.frozen != 0 ? shot.frozen : set.number, k, out);
    }
    frame.samples[index] = out;
    frame.exposures[index] = set.exposures[index];
  }
  return frame;
}

}  // namespace stof::hal::emu
