#include "dsp/base/avx2.h"
#include "dsp/stereo/search/numbered_right_winners.h"
#include "dsp/stereo/search/numbered_right_winners_body.h"

namespace stof::dsp::avx512 {
namespace {

struct NumberedLanes {
  using V = __m512i;
  static constexpr std::size_t kLanes = 32;

  static V load(const std::uint16_t* p) noexcept { return _mm512_loadu_si512(p); }
  static V all(std::uint16_t v) noexcept { return _mm512_set1_epi16(static_cast<std::int16_t>(v)); }
  static V smaller(V a, V b) noexcept { return _mm512_min_epu16(a, b); }
  static V either(V a, V b) noexcept { return _mm512_or_si512(a, b); }
  static V add(V a, V b) noexcept { return _mm512_add_epi16(a, b); }
  static V repeated(const std::uint16_t* p) noexcept {
    return _mm512_broadcast_i32x4(
        _mm_loadu_si128(reinterpret_cast<const __m128i*>(p)));  // NOLINT: any type
  }
  static V number_where_equal(V number, V a, V lowest) noexcept {
    return _mm512_mask_mov_epi16(number, _mm512_cmpgt_epu16_mask(a, lowest), none());
  }
  static V winners_of(V lowest, V number) noexcept {
    return either(_mm512_slli_epi16(_mm512_and_si512(lowest, all(7)), 3), number);
  }
  static __mmask32 better(V a, V b) noexcept {
    return _mm512_cmplt_epu16_mask(_mm512_srli_epi16(a, 3), _mm512_srli_epi16(b, 3));
  }
  static V select(__mmask32 mask, V a, V b) noexcept { return _mm512_mask_mov_epi16(b, mask, a); }

  template <int kSkipped>
  static V first_of(const std::uint16_t* column) noexcept {
    return _mm512_mask_loadu_epi16(none(), ~std::uint32_t{0} << kSkipped, column - kSkipped);
  }
  template <int kSkipped>
  static V last_of(const std::uint16_t* column) noexcept {
    return _mm512_mask_loadu_epi16(none(), ~std::uint32_t{0} >> kSkipped, column + kSkipped);
  }
  static void store(V lowest, V winner, std::int16_t* to) noexcept {
    const __mmask32 missing = _mm512_cmpeq_epu16_mask(lowest, none());
    avx2::store_bits(to, _mm512_mask_mov_epi16(winner, missing, none()));
  }

 private:
  static V none() noexcept { return _mm512_set1_epi16(-1); }
};

}  // namespace

void numbered_right_winners(std::span<const std::uint16_t> costs, int lanes,
                            std::span<std::int16_t> winners) noexcept {
  if (lanes % static_cast<int>(NumberedLanes::kLanes) != 0) {
    avx2::numbered_right_winners(costs, lanes, winners);
    return;
  }
  numbered_right_winners_body::find<NumberedLanes>(costs, lanes, winners);
}

}  // namespace stof::dsp::avx512
