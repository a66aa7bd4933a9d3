#include "dsp/base/avx2.h"
#include "dsp/stereo/search/right_winners_body.h"
#include "dsp/stereo/search/winner.h"

namespace stof::dsp::avx512 {
namespace {

template <typename Sum>
struct RightLanes;

struct AnyLanes {
  using V = __m512i;
  static V either(V a, V b) noexcept { return _mm512_or_si512(a, b); }
};

template <>
struct RightLanes<std::uint8_t> : AnyLanes {
  using Lane = std::uint8_t;
  static constexpr std::size_t kLanes = 64;

  static V load(const Lane* p) noexcept { return _mm512_loadu_si512(p); }
  static V all(Lane v) noexcept { return _mm512_set1_epi8(static_cast<char>(v)); }
  static V next(V v) noexcept { return _mm512_add_epi8(v, all(1)); }
  static void meet(V costs, V candidate, V& lowest, V& winner) noexcept {
    winner = _mm512_mask_mov_epi8(winner, _mm512_cmplt_epu8_mask(costs, lowest), candidate);
    lowest = _mm512_min_epu8(lowest, costs);
  }
  static void store(V lowest, V winner, Lane* to_lowest, std::int16_t* to_winners) noexcept {
    avx2::store_bits(to_lowest, lowest);
    const __mmask64 missing = _mm512_cmpeq_epu8_mask(lowest, all(kNoCost<Lane>));
    store_half(_mm512_castsi512_si256(winner), static_cast<__mmask32>(missing), to_winners);
    store_half(_mm512_extracti64x4_epi64(winner, 1), static_cast<__mmask32>(missing >> 32),
               to_winners + 32);
  }

 private:
  static void store_half(__m256i winner, __mmask32 missing, std::int16_t* to) noexcept {
    avx2::store_bits(to, _mm512_mask_mov_epi16(_mm512_cvtepu8_epi16(winner), missing,
                                               _mm512_set1_epi16(kNoWinner)));
  }
};

template <>
struct RightLanes<std::uint16_t> : AnyLanes {
  using Lane = std::uint16_t;
  static constexpr std::size_t kLanes = 32;

  static V load(const Lane* p) noexcept { return _mm512_loadu_si512(p); }
  static V all(Lane v) noexcept { return _mm512_set1_epi16(static_cast<std::int16_t>(v)); }
  static V next(V v) noexcept { return _mm512_add_epi16(v, all(1)); }
  static void meet(V costs, V candidate, V& lowest, V& winner) noexcept {
    winner = _mm512_mask_mov_epi16(winner, _mm512_cmplt_epu16_mask(costs, lowest), candidate);
    lowest = _mm512_min_epu16(lowest, costs);
  }
  static void store(V lowest, V winner, Lane* to_lowest, std::int16_t* to_winners) noexcept {
    avx2::store_bits(to_lowest, lowest);
    const __mmask32 missing = _mm512_cmpeq_epu16_mask(lowest, all(kNoCost<Lane>));
    avx2::store_bits(to_winners,
                     _mm512_mask_mov_epi16(winner, missing, _mm512_set1_epi16(kNoWinner)));
  }
};

}  // namespace

template <typename Sum>
void right_winners(std::span<const Sum> costs, int lanes, std::span<Sum> lowest,
                   std::span<std::int16_t> winners) noexcept {
  if (lanes % static_cast<int>(RightLanes<Sum>::kLanes) != 0) {
    avx2::right_winners(costs, lanes, lowest, winners);
    return;
  }
  right_winners_body::find<RightLanes<Sum>>(costs, lanes, lowest, winners);
}

STOF_INSTANTIATE(RightWinners, right_winners, std::uint8_t, std::uint16_t);

}  // namespace stof::dsp::avx512
