#include <cstddef>
#include <type_traits>

#include "dsp/base/avx2.h"
#include "dsp/stereo/validation/peak_ratio.h"
#include "dsp/stereo/validation/peak_ratio_body.h"

namespace stof::dsp::avx512 {
namespace {

struct Peaks {
  static constexpr std::size_t kLanes = 32;

  static std::uint16_t lowest(const std::uint16_t* costs, const std::uint16_t* near,
                              std::size_t count) noexcept {
    __m512i least = both(costs, near);
    for (std::size_t i = kLanes; i < count; i += kLanes) {
      least = _mm512_min_epu16(least, both(costs + i, near + i));
    }
    const __m256i half =
        _mm256_min_epu16(_mm512_castsi512_si256(least), _mm512_extracti64x4_epi64(least, 1));
    const __m128i quarter =
        _mm_min_epu16(_mm256_castsi256_si128(half), _mm256_extracti128_si256(half, 1));
    return static_cast<std::uint16_t>(_mm_cvtsi128_si32(_mm_minpos_epu16(quarter)));
  }

  static void put_ratios(const std::uint16_t* own, const std::uint16_t* rival, int shift,
                         std::uint8_t* to) noexcept {
    const __m128i down = _mm_cvtsi32_si128(shift);
    const __m512i best = sixteen(rival);
    const __mmask16 some =
        _mm512_cmpneq_epu32_mask(best, _mm512_set1_epi32(kNoCost<std::uint16_t>));
    const __m512i c = _mm512_srl_epi32(sixteen(own), down);
    const __m512i r = _mm512_maskz_srl_epi32(some, best, down);
    const __m512 scaled = _mm512_mul_ps(_mm512_set1_ps(255.0F), _mm512_cvtepi32_ps(c));
    const __m512i quotient = _mm512_cvttps_epi32(_mm512_div_ps(scaled, _mm512_cvtepi32_ps(r)));
    avx2::store_bits(to, _mm512_cvtepi32_epi8(_mm512_mask_mov_epi32(
                             _mm512_set1_epi32(255), _mm512_cmplt_epu32_mask(c, r), quotient)));
  }

 private:
  static __m512i both(const std::uint16_t* costs, const std::uint16_t* near) noexcept {
    return _mm512_or_si512(_mm512_loadu_si512(costs), _mm512_loadu_si512(near));
  }
  // Pixels, a lane each.
  static __m512i sixteen(const std::uint16_t* p) noexcept {
    return _mm512_cvtepu16_epi32(
        _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p)));  // NOLINT: any type
  }
};

}  // namespace

template <typename Sum>
void peak_ratio(std::span<const Sum> costs, int lanes, bool numbered,
                std::span<const std::int16_t> winners, std::span<std::uint8_t> ratio) noexcept {
  static_assert(std::is_same_v<Sum, std::uint16_t>);
  if (lanes % static_cast<int>(Peaks::kLanes) != 0) {
    avx2::peak_ratio(costs, lanes, numbered, winners, ratio);
    return;
  }
  const std::size_t x =
      peak_ratio_body::Ratios<Peaks, Sum>::find(costs, lanes, numbered, winners, ratio);
  neon::peak_ratio(costs.subspan(x * static_cast<std::size_t>(lanes)), lanes, numbered,
                   winners.subspan(x), ratio.subspan(x));
}

STOF_INSTANTIATE(PeakRatio, peak_ratio, std::uint16_t);

}  // namespace stof::dsp::avx512
