#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/base/status.h"
#include "dsp/calib/calibration.h"

namespace stof::dsp {

using PmdSamples = std::array<ImageView<const std::uint16_t>, 4>;

// Why a PMD pixel is or is not to be trusted (SPEC section 2). A pixel with any bit of kPmdMissing
// carries no distance.
enum PmdFlag : std::uint8_t {
  kPmdSaturated = 1 << 0,
  kPmdUnderRange = 1 << 1,
  kPmdLowAmplitude = 1 << 2,
  kPmdLowRatio = 1 << 3,
  kPmdAsymmetric = 1 << 4,
  kPmdEdge = 1 << 5,
  kPmdOutOfRange = 1 << 6,
  kPmdWrapped = 1 << 7,
};
inline constexpr std::uint8_t kPmdMissing =
    kPmdSaturated | kPmdUnderRange | kPmdLowAmplitude | kPmdLowRatio | kPmdAsymmetric | kPmdWrapped;

// Everything one PMD frame becomes. All images have the sensor's size.
struct PmdMaps {
  ImageView<Phase> phase;           // before any correction
  ImageView<std::uint16_t> amp2;    // twice the amplitude, LSB
  ImageView<std::uint16_t> offset;  // mean of the samples less dark, LSB
  ImageView<std::uint8_t> flags;    // PmdFlag
  ImageView<QuarterMm> distance;    // radial, along the pixel's ray; 0 = none
  ImageView<QuarterMm> sigma;       // of distance
  ImageView<QuarterMm> low;         // radial interval from the 3x3 neighbourhood, with 2 sigma;
  ImageView<QuarterMm> high;        // both 0 where there is none
};

// Four samples to distance with an interval: phase, range, interval kernels with this sensor's
// tables. Holds its buffers, allocates nothing after construction.
class Converter {
 public:
  static std::size_t bytes_needed(int width, int height) noexcept;

  // Builds the tables; sensor.lens gives the size. problem(calibration) must be empty.
  Converter(const PmdSensor& sensor, Arena& arena) noexcept;

  // Samples of the sensor's size. The result is valid until the next call.
  const PmdMaps& convert(const PmdSamples& samples) noexcept;

 private:
  struct Tables;
  Tables* tables_;
  PmdMaps maps_;
};

}  // namespace stof::dsp
