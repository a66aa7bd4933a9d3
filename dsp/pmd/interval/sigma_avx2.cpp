#include "dsp/pmd/interval/sigma.h"

#include <cstddef>

#include "dsp/base/avx2.h"
#include "dsp/base/check.h"

namespace stof::dsp::avx2 {
namespace {

constexpr std::size_t kLanes = 16;

// Sixteen numbers as singles: of each eight the lower four, of each eight the upper four.
struct Singles {
  __m256 low;
  __m256 high;
};

Singles to_float(u16x16 v) noexcept {
  const __m256i none = _mm256_setzero_si256();
  return {_mm256_cvtepi32_ps(_mm256_unpacklo_epi16(bits(v), none)),
          _mm256_cvtepi32_ps(_mm256_unpackhi_epi16(bits(v), none))};
}

// Nearest integers, ties to even, at most 65535.
u16x16 rounded(const Singles& v) noexcept {
  return as<u16x16>(_mm256_packus_epi32(_mm256_cvtps_epi32(v.low), _mm256_cvtps_epi32(v.high)));
}

__m256 shot(__m256 amp2, __m256 light, const NoiseModel& model) noexcept {
  const __m256 variance =
      _mm256_add_ps(_mm256_mul_ps(_mm256_set1_ps(model.slope), light), _mm256_set1_ps(model.base));
  const __m256 sigma =
      _mm256_div_ps(_mm256_sqrt_ps(variance), _mm256_max_ps(amp2, _mm256_set1_ps(1.0F)));
  return _mm256_min_ps(sigma, _mm256_set1_ps(65535.0F));
}

__m256 modulation(__m256 amp2, __m256 light) noexcept {
  const __m256 ratio = _mm256_div_ps(_mm256_mul_ps(amp2, _mm256_set1_ps(128.0F)),
                                     _mm256_max_ps(light, _mm256_set1_ps(1.0F)));
  return _mm256_min_ps(ratio, _mm256_set1_ps(255.0F));
}

struct Quality {
  u16x16 sigma;
  u16x16 ratio;
};

Quality quality_of(u16x16 amp2, u16x16 offset, const NoiseModel& model) noexcept {
  const Singles twice = to_float(amp2);
  const Singles light = to_float(offset);
  const u16x16 sigma =
      rounded({shot(twice.low, light.low, model), shot(twice.high, light.high, model)});
  return {larger(sigma, all(std::uint16_t{1})),
          rounded({modulation(twice.low, light.low), modulation(twice.high, light.high)})};
}

__m256 combined(__m256 a, __m256 b) noexcept {
  const __m256 both = _mm256_add_ps(_mm256_mul_ps(a, a), _mm256_mul_ps(b, b));
  return _mm256_div_ps(_mm256_mul_ps(a, b), _mm256_sqrt_ps(both));
}

}  // namespace

void sigma_and_ratio(std::span<const std::uint16_t> amp2, std::span<const std::uint16_t> offset,
                     const NoiseModel& model, std::span<QuarterMm> sigma,
                     std::span<std::uint8_t> ratio) noexcept {
  const std::size_t n = sigma.size();
  STOF_CHECK(amp2.size() == n && offset.size() == n && ratio.size() == n);
  const NoiseModel own = model;  // ratio may alias what is known of it
  std::size_t x = 0;
  for (; x + kLanes <= n; x += kLanes) {
    const Quality here =
        quality_of(load<u16x16>(amp2.data() + x), load<u16x16>(offset.data() + x), own);
    store(sigma.data() + x, here.sigma);
    const __m256i packed = _mm256_packus_epi16(bits(here.ratio), bits(here.ratio));
    store_half(ratio.data() + x,
               as<u8x32>(_mm256_permute4x64_epi64(packed, _MM_SHUFFLE(3, 1, 2, 0))));
  }
  neon::sigma_and_ratio(amp2.subspan(x), offset.subspan(x), model, sigma.subspan(x),
                        ratio.subspan(x));
}

void combine_sigma(std::span<const QuarterMm> other, std::span<QuarterMm> sigma) noexcept {
  STOF_CHECK(other.size() == sigma.size());
  std::size_t x = 0;
  for (; x + kLanes <= sigma.size(); x += kLanes) {
    const Singles a = to_float(load<u16x16>(sigma.data() + x));
    const Singles b = to_float(load<u16x16>(other.data() + x));
    const u16x16 mean = rounded({combined(a.low, b.low), combined(a.high, b.high)});
    store(sigma.data() + x, larger(mean, all(std::uint16_t{1})));
  }
  neon::combine_sigma(other.subspan(x), sigma.subspan(x));
}

}  // namespace stof::dsp::avx2
