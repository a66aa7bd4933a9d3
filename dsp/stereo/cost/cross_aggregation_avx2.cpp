#include "dsp/base/lanes_avx2.h"
#include "dsp/stereo/cost/cross_aggregation_body.h"

namespace stof::dsp::avx2 {
namespace {

struct Isa : Lanes<std::uint8_t> {
  static V means(V a, V b, V c, std::int16_t reciprocal) noexcept {
    // Within each half, as packing does.
    const auto low = [](V v) noexcept {
      return _mm256_unpacklo_epi8(bits(v), _mm256_setzero_si256());
    };
    const auto high = [](V v) noexcept {
      return _mm256_unpackhi_epi8(bits(v), _mm256_setzero_si256());
    };
    const __m256i scale = _mm256_set1_epi16(reciprocal);
    const auto mean = [scale](__m256i x, __m256i y, __m256i z) noexcept {
      return _mm256_mulhrs_epi16(_mm256_add_epi16(_mm256_add_epi16(x, y), z), scale);
    };
    return as<V>(
        _mm256_packus_epi16(mean(low(a), low(b), low(c)), mean(high(a), high(b), high(c))));
  }
};

bool serves(int lanes) noexcept { return lanes % static_cast<int>(Isa::kLanes) == 0; }

}  // namespace

void sum_alike(std::span<const std::uint8_t> costs, std::span<const std::uint8_t> joined, int lanes,
               std::span<std::uint8_t> sums) noexcept {
  if (!serves(lanes)) {
    neon::sum_alike(costs, joined, lanes, sums);
    return;
  }
  cross_aggregation_body::sum_alike<Isa>(costs, joined, lanes, sums);
}

void cross_means(const CrossRows& rows, int lanes, std::span<std::uint8_t> means) noexcept {
  if (!serves(lanes)) {
    neon::cross_means(rows, lanes, means);
    return;
  }
  cross_aggregation_body::cross_means<Isa>(rows, lanes, means);
}

}  // namespace stof::dsp::avx2
