#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "dsp/base/image.h"

namespace stof::firmware {

// Tells a picture whose pixels are those of the picture before, under whatever number and stamp: of
// a sensor that hangs, or of a driver that hands out an old buffer. The noise of light makes any
// two exposures differ, also where nothing moves. It looks at every 16th row.
//
// Values at both ends of the scale may have no noise: where nearly all are there (a covered lens, a
// blinded one), equal pictures prove nothing.
template <typename Pixel>
class RepeatDetector {
 public:
  // Values between `dark` and `bright` have noise.
  RepeatDetector(int dark, int bright) noexcept : dark_(dark), bright_(bright) {}

  // Whether these images together are those of the call before.
  bool repeats(std::span<const dsp::ImageView<const Pixel>> images) noexcept;

 private:
  bool proves(std::span<const dsp::ImageView<const Pixel>> images) const noexcept;

  int dark_;
  int bright_;
  std::optional<std::uint64_t> digest_;  // of the call before
};

extern template class RepeatDetector<std::uint8_t>;
extern template class RepeatDetector<std::uint16_t>;

}  // namespace stof::firmware
