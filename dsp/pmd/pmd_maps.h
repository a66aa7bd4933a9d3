#pragma once

#include <cstdint>

#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/calib/pinhole.h"

namespace stof::dsp {

// Why a PMD pixel is or is not to be trusted. A pixel with any bit of kPmdMissing
// carries no distance.
enum PmdFlag : std::uint8_t {
  kPmdSaturated = 1 << 0,
  kPmdUnderRange = 1 << 1,
  kPmdLowAmplitude = 1 << 2,
  kPmdLowRatio = 1 << 3,
  kPmdAsymmetric = 1 << 4,  // motion or changing light between the samples
  kPmdEdge = 1 << 5,
  kPmdOutOfRange = 1 << 6,  // more than 16.38 m (no `distance`), or the interval reaches there
  kPmdWrapped = 1 << 7,     // may as well lie a range nearer or further
};
inline constexpr std::uint8_t kPmdMissing =
    kPmdSaturated | kPmdUnderRange | kPmdLowAmplitude | kPmdLowRatio | kPmdAsymmetric | kPmdWrapped;

// A relative integration time in Q8: 256 is the sensor's reference (PmdSensor::integration_us).
using IntegrationQ8 = std::uint16_t;
inline constexpr IntegrationQ8 kReferenceIntegration = 256;

// Whether neighbouring pixels of a lens mostly see one surface: 80 px of focal length are 0.7
// degrees a pixel. The chapter's 64x16 pixels are 1.3 degrees wide: averaging them made intervals
// of five scenes narrower, and wrong.
constexpr bool is_fine(const Pinhole& lens) noexcept {
  constexpr double kShortestFocal = 80;
  return lens.fx >= kShortestFocal && lens.fy >= kShortestFocal;
}

// Everything one PMD frame becomes. All images have the sensor's size; with two frequencies, phase
// to ratio are those of the first.
struct PmdMaps {
  ImageView<Phase> phase;           // stray light subtracted, otherwise before any correction
  ImageView<std::uint16_t> amp2;    // twice the amplitude, LSB
  ImageView<std::uint16_t> offset;  // mean of the samples less dark, LSB
  ImageView<std::uint8_t> flags;    // PmdFlag
  // Radial, along the pixel's ray; 0 = none. Rows of distance and sigma are padded: stride is
  // width + 2, and the element before and the one behind each row are there and always 0, which is
  // what the kernel `interval` wants at the border.
  ImageView<QuarterMm> distance;
  ImageView<QuarterMm> sigma;  // of distance
  // Both averaged along surfaces (interval/average_pairs.h): what intervals are made of and where
  // readings lie in the left view. Padded likewise. Empty where a pixel is too wide for that:
  // readings themselves are used.
  ImageView<QuarterMm> smoothed;
  ImageView<QuarterMm> smoothed_sigma;
  // Of pixels with kPmdWrapped, which have no distance: what was read, less than `range`, and its
  // sigma. It lies at this, or any number of ranges away. 0 elsewhere, and of fine pixels (is_fine)
  // whose neighbours are an edge and more than `widest` apart: there it may be mixed, and tell
  // neither. Wide ones keep it, with kPmdEdge. May be empty.
  ImageView<QuarterMm> folded;
  ImageView<QuarterMm> folded_sigma;
  ImageView<QuarterMm> low;       // radial interval from the 3x3 neighbourhood, with 2 sigma;
  ImageView<QuarterMm> high;      // both 0 where there is none
  ImageView<std::uint8_t> ratio;  // modulation ratio m = A / offset, LSB 1/256, at most 255
  // The same distance without the limit of 16.38 m: 0.1 mm, 0 = none. Empty unless the sensor has a
  // second frequency or a turn that is longer than 16.38 m.
  ImageView<std::uint32_t> long_distance;
  // The integration time that amp2 and offset refer to: of the frame's longest exposure of the
  // first frequency. What a pixel took from a shorter one was multiplied (up to 65535), so that
  // amp2 * 256 / (2 * integration) compares to PmdSensor::white_lsb in every pixel.
  IntegrationQ8 integration = kReferenceIntegration;
  // After how much readings repeat, quarter mm: one turn, with two frequencies their common range;
  // times PmdSensor::scale.
  std::uint32_t range = 0;
  // Readings further apart than this tell nothing about what lies between them: half a turn of the
  // first frequency, quarter mm, whether or not a second one tells turns apart.
  QuarterMm widest = 0;
  // Something moved while the samples were taken (phase/motion_correction.h).
  bool moved = false;
  // What a surface tilted by 60 degrees gains over two pixels, as a share of its distance, Q16.
  std::uint16_t slope_q16 = 0;

  // Where readings lie.
  const ImageView<QuarterMm>& located() const noexcept {
    return smoothed.empty() ? distance : smoothed;
  }
};

}  // namespace stof::dsp
