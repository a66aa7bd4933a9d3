#pragma once

#include "dsp/base/avx2.h"

// The common part of the 3x3 filters of this folder, for their *_avx2.cpp.
namespace stof::dsp::avx2 {

// 32 bytes as words: the lower and the upper eight of both halves.
struct Words {
  u16x16 low, high;
};
static inline Words widened(u8x32 v) noexcept {
  const __m256i zero = _mm256_setzero_si256();
  return {.low = as<u16x16>(_mm256_unpacklo_epi8(bits(v), zero)),
          .high = as<u16x16>(_mm256_unpackhi_epi8(bits(v), zero))};
}
// above + 2 here + below.
static inline Words column_sums(const std::uint8_t* above, const std::uint8_t* here,
                                const std::uint8_t* below) noexcept {
  const Words a = widened(load<u8x32>(above));
  const Words h = widened(load<u8x32>(here));
  const Words b = widened(load<u8x32>(below));
  return {.low = a.low + b.low + h.low + h.low, .high = a.high + b.high + h.high + h.high};
}

}  // namespace stof::dsp::avx2
