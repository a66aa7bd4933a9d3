#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "dsp/base/avx2.h"
#include "dsp/fusion/temporal/temporal_row_body.h"

namespace stof::dsp::avx512 {
namespace {

// Masks are written as lanes: the compiler keeps them in mask registers.
template <typename LaneType>
struct Lanes {
  using Lane = LaneType;
  using V [[gnu::vector_size(64)]] = Lane;
  static constexpr std::size_t kLanes = 64 / sizeof(Lane);

  static V load(const Lane* p) noexcept { return of(_mm512_loadu_si512(p)); }
  static void store(Lane* p, V v) noexcept { avx2::store_bits(p, bits(v)); }
  static V all(Lane v) noexcept { return V{} + v; }
  static V smaller(V a, V b) noexcept { return a < b ? a : b; }
  static V larger(V a, V b) noexcept { return a > b ? a : b; }
  static V difference(V a, V b) noexcept { return larger(a, b) - smaller(a, b); }
  static V at_most(V a, V b) noexcept { return std::bit_cast<V>(a <= b); }
  static V equal(V a, V b) noexcept { return std::bit_cast<V>(a == b); }
  static V select(V mask, V a, V b) noexcept { return mask != V{} ? a : b; }

  static __m512i bits(V v) noexcept { return std::bit_cast<__m512i>(v); }
  static V of(__m512i v) noexcept { return std::bit_cast<V>(v); }
};

struct LanesOfWords : Lanes<std::uint16_t> {
  static V add_saturated(V a, V b) noexcept { return of(_mm512_adds_epu16(bits(a), bits(b))); }
  static V subtract_saturated(V a, V b) noexcept { return of(_mm512_subs_epu16(bits(a), bits(b))); }
  static V signed_sixteenth(V a) noexcept { return of(_mm512_srai_epi16(bits(a), 4)); }
  static V signed_scaled_product(V a, V b) noexcept {
    return of(_mm512_mulhrs_epi16(bits(a), bits(b)));
  }
};

struct Isa {
  using Words = LanesOfWords;
  using Bytes = Lanes<std::uint8_t>;
  using V = Words::V;
  using B = Bytes::V;

  static B load_bytes(const std::uint8_t* p) noexcept { return Bytes::load(p); }
  static void store_bytes(std::uint8_t* p, B v) noexcept { Bytes::store(p, v); }
  static B as_bytes(V lower, V upper) noexcept {
    const __m512i first = _mm512_castsi256_si512(_mm512_cvtepi16_epi8(Words::bits(lower)));
    return Bytes::of(_mm512_inserti64x4(first, _mm512_cvtepi16_epi8(Words::bits(upper)), 1));
  }
  static V lower(B low, B high) noexcept {
    return words(lower_half(low)) | (words(lower_half(high)) << 8);
  }
  static V upper(B low, B high) noexcept {
    return words(upper_half(low)) | (words(upper_half(high)) << 8);
  }
  static V lower_mask(B mask) noexcept { return mask_of(one_each(mask)); }
  static V upper_mask(B mask) noexcept { return mask_of(one_each(mask) >> 32); }
  static B look_up(const std::array<std::uint8_t, 16>& table, B v) noexcept {
    const __m128i entries =
        _mm_loadu_si128(reinterpret_cast<const __m128i*>(table.data()));  // NOLINT: any type
    return Bytes::of(_mm512_shuffle_epi8(_mm512_broadcast_i32x4(entries), Bytes::bits(v)));
  }

 private:
  static __m256i lower_half(B v) noexcept { return _mm512_castsi512_si256(Bytes::bits(v)); }
  static __m256i upper_half(B v) noexcept { return _mm512_extracti64x4_epi64(Bytes::bits(v), 1); }
  static V words(__m256i bytes) noexcept { return Words::of(_mm512_cvtepu8_epi16(bytes)); }
  static __mmask64 one_each(B mask) noexcept { return _mm512_movepi8_mask(Bytes::bits(mask)); }
  static V mask_of(__mmask64 lanes) noexcept {
    return Words::of(_mm512_movm_epi16(static_cast<__mmask32>(lanes)));
  }
};

}  // namespace

void temporal_row(const TemporalRow& row, const TemporalLimits& limits,
                  const TemporalState& state) noexcept {
  temporal_row_body::temporal_row<Isa>(row, limits, state, avx2::temporal_row);
}

}  // namespace stof::dsp::avx512
