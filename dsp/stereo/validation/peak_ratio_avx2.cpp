#include "dsp/stereo/validation/peak_ratio.h"

#include <cstddef>

#include "dsp/base/lanes_avx2.h"
#include "dsp/stereo/validation/peak_ratio_body.h"

namespace stof::dsp::avx2 {
namespace {

// Eight pixels, a lane each.
u32x8 eight(const std::uint8_t* p) noexcept {
  return as<u32x8>(
      _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p))));  // NOLINT
}
u32x8 eight(const std::uint16_t* p) noexcept {
  return as<u32x8>(
      _mm256_cvtepu16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p))));  // NOLINT
}

template <typename Sum>
struct Peaks {
  using L = Lanes<Sum>;

  static Sum lowest(const Sum* costs, const Sum* near, std::size_t count) noexcept {
    auto least = L::load(costs) | L::load(near);
    for (std::size_t i = L::kLanes; i < count; i += L::kLanes) {
      least = L::smaller(least, L::load(costs + i) | L::load(near + i));
    }
    return L::lowest(least)[0];
  }

  static void put_ratios(const Sum* own, const Sum* rival, int shift, std::uint8_t* to) noexcept {
    const __m256i low = ratio(eight(own), eight(rival), shift);
    const __m256i high = ratio(eight(own + 8), eight(rival + 8), shift);
    const __m256i words = _mm256_permute4x64_epi64(_mm256_packus_epi32(low, high), 0xD8);
    store_bits(to,
               _mm_packus_epi16(_mm256_castsi256_si128(words), _mm256_extracti128_si256(words, 1)));
  }

 private:
  static __m256i ratio(u32x8 own, u32x8 rival, int shift) noexcept {
    const __m128i down = _mm_cvtsi32_si128(shift);
    const __m256i some =
        _mm256_andnot_si256(bits(rival == all(std::uint32_t{kNoCost<Sum>})), bits(rival));
    const __m256i c = _mm256_srl_epi32(bits(own), down);
    const __m256i r = _mm256_srl_epi32(some, down);
    const __m256 scaled = _mm256_mul_ps(_mm256_set1_ps(255.0F), _mm256_cvtepi32_ps(c));
    const __m256i quotient = _mm256_cvttps_epi32(_mm256_div_ps(scaled, _mm256_cvtepi32_ps(r)));
    return _mm256_blendv_epi8(_mm256_set1_epi32(255), quotient, _mm256_cmpgt_epi32(r, c));
  }
};

}  // namespace

template <typename Sum>
void peak_ratio(std::span<const Sum> costs, int lanes, bool numbered,
                std::span<const std::int16_t> winners, std::span<std::uint8_t> ratio) noexcept {
  if (lanes % static_cast<int>(Lanes<Sum>::kLanes) != 0) {
    neon::peak_ratio(costs, lanes, numbered, winners, ratio);
    return;
  }
  const std::size_t x =
      peak_ratio_body::Ratios<Peaks<Sum>, Sum>::find(costs, lanes, numbered, winners, ratio);
  neon::peak_ratio(costs.subspan(x * static_cast<std::size_t>(lanes)), lanes, numbered,
                   winners.subspan(x), ratio.subspan(x));
}

STOF_INSTANTIATE(PeakRatio, peak_ratio, std::uint8_t, std::uint16_t);

}  // namespace stof::dsp::avx2
