#include <array>
#include <bit>
#include <cstdint>

#include "dsp/base/lanes_neon.h"
#include "dsp/fusion/temporal/temporal_row_body.h"

namespace stof::dsp::neon {
namespace {

struct Isa {
  using Words = Lanes<std::uint16_t>;
  using Bytes = Lanes<std::uint8_t>;
  using V = Words::V;
  using B = Bytes::V;

  static B load_bytes(const std::uint8_t* p) noexcept { return vld1q_u8(p); }
  static void store_bytes(std::uint8_t* p, B v) noexcept { vst1q_u8(p, v); }
  static B as_bytes(V lower, V upper) noexcept {
#if defined(__SSE2__)
    return std::bit_cast<B>(
        _mm_packs_epi16(std::bit_cast<__m128i>(lower), std::bit_cast<__m128i>(upper)));
#else
    return vuzp1q_u8(vreinterpretq_u8_u16(lower), vreinterpretq_u8_u16(upper));
#endif
  }
  static V lower(B low, B high) noexcept { return vreinterpretq_u16_u8(vzip1q_u8(low, high)); }
  static V upper(B low, B high) noexcept { return vreinterpretq_u16_u8(vzip2q_u8(low, high)); }
  static V lower_mask(B mask) noexcept { return lower(mask, mask); }
  static V upper_mask(B mask) noexcept { return upper(mask, mask); }
  static B look_up(const std::array<std::uint8_t, 16>& table, B v) noexcept {
    return simd::look_up(vld1q_u8(table.data()), v);
  }
};

}  // namespace

void temporal_row(const TemporalRow& row, const TemporalLimits& limits,
                  const TemporalState& state) noexcept {
  temporal_row_body::temporal_row<Isa>(row, limits, state, ref::temporal_row);
}

}  // namespace stof::dsp::neon
