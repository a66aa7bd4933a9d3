#include <array>
#include <cstdint>

#include "dsp/base/lanes_avx2.h"
#include "dsp/fusion/temporal/temporal_row_body.h"

namespace stof::dsp::avx2 {
namespace {

struct Isa {
  using Words = Lanes<std::uint16_t>;
  using Bytes = Lanes<std::uint8_t>;
  using V = Words::V;
  using B = Bytes::V;

  static B load_bytes(const std::uint8_t* p) noexcept { return in_halves(Bytes::load(p)); }
  static void store_bytes(std::uint8_t* p, B v) noexcept { Bytes::store(p, in_halves(v)); }
  static B as_bytes(V lower, V upper) noexcept {
    return as<B>(_mm256_packs_epi16(bits(lower), bits(upper)));
  }
  static V lower(B low, B high) noexcept {
    return as<V>(_mm256_unpacklo_epi8(bits(low), bits(high)));
  }
  static V upper(B low, B high) noexcept {
    return as<V>(_mm256_unpackhi_epi8(bits(low), bits(high)));
  }
  static V lower_mask(B mask) noexcept { return lower(mask, mask); }
  static V upper_mask(B mask) noexcept { return upper(mask, mask); }
  static B look_up(const std::array<std::uint8_t, 16>& table, B v) noexcept {
    const __m128i entries =
        _mm_loadu_si128(reinterpret_cast<const __m128i*>(table.data()));  // NOLINT: any type
    return as<B>(_mm256_shuffle_epi8(_mm256_broadcastsi128_si256(entries), bits(v)));
  }

 private:
  // The instructions above work in halves of 128 bits: the quarters in the middle change places.
  static B in_halves(B v) noexcept { return as<B>(_mm256_permute4x64_epi64(bits(v), 0xD8)); }
};

}  // namespace

void temporal_row(const TemporalRow& row, const TemporalLimits& limits,
                  const TemporalState& state) noexcept {
  temporal_row_body::temporal_row<Isa>(row, limits, state, neon::temporal_row);
}

}  // namespace stof::dsp::avx2
