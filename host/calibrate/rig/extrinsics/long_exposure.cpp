#include "host/calibrate/rig/extrinsics/long_exposure.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace stof::host {
namespace {

constexpr int kLargestSample = 32767;  // that the appliance reads (dsp/pmd/phase/phase.h)

// The constants of a camera whose every sample is the sum of so many.
dsp::PmdSensor adding(const dsp::PmdSensor& sensor, int frames) noexcept {
  dsp::PmdSensor sum = sensor;
  sum.frequency.stray_i_lsb *= frames;
  sum.frequency.stray_q_lsb *= frames;
  sum.dark_lsb *= frames;
  sum.saturation_lsb *= frames;
  sum.under_lsb *= frames;
  sum.min_amplitude_lsb *= frames;
  sum.noise_lsb *= std::sqrt(frames);
  sum.suppressed_lsb *= frames;
  sum.white_lsb *= frames;
  return sum;
}

dataset::Image<std::uint16_t> sum_of(std::span<const dataset::Image<std::uint16_t>> frames,
                                     const dsp::PmdSensor& sensor) {
  const int count = static_cast<int>(frames.size());
  dataset::Image<std::uint16_t> sum(frames.front().width, frames.front().height);
  for (std::size_t p = 0; p < sum.pixels.size(); ++p) {
    int total = 0;
    bool saturated = false;
    bool under = false;
    for (const dataset::Image<std::uint16_t>& frame : frames) {
      const int sample = frame.pixels[p];
      total += sample;
      saturated = saturated || sample >= sensor.saturation_lsb;
      under = under || sample <= sensor.under_lsb;
    }
    total = under ? std::min(total, sensor.under_lsb * count) : total;
    total = saturated ? std::max(total, sensor.saturation_lsb * count) : total;
    sum.pixels[p] = static_cast<std::uint16_t>(std::min<int>(total, UINT16_MAX));
  }
  return sum;
}

}  // namespace

LongExposures lengthened(dataset::PmdRecording recording, const dsp::PmdSensor& sensor) {
  const std::size_t frames = recording.frames.size();
  const auto room =
      static_cast<std::size_t>(std::max(1, kLargestSample / std::max(1, sensor.saturation_lsb)));
  const std::size_t sums = (frames + room - 1) / room;
  const std::size_t each = sums == 0 ? 1 : frames / sums;
  std::vector<dataset::Image<std::uint16_t>> summed;
  summed.reserve(sums);
  const std::span<const dataset::Image<std::uint16_t>> all = recording.frames;
  for (std::size_t n = 0; n < sums; ++n) {
    summed.push_back(sum_of(all.subspan(n * each, each), sensor));
  }
  recording.frames = std::move(summed);
  recording.second_frames.clear();
  return {.recording = std::move(recording), .sensor = adding(sensor, static_cast<int>(each))};
}

}  // namespace stof::host
