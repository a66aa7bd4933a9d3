#include "dsp/base/lanes_avx2.h"
#include "dsp/stereo/cost/cross_aggregation_body.h"

namespace stof::dsp::avx2 {
namespace {

struct Isa : Lanes<std::uint16_t> {
  template <std::size_t kVectors>
  static void add_bytes(const std::uint8_t* costs, V (&sums)[kVectors]) noexcept {
    for (std::size_t v = 0; v < kVectors; ++v) {
      const auto* const at =
          reinterpret_cast<const __m128i*>(costs + v * kLanes);  // NOLINT: any type
      sums[v] += as<V>(_mm256_cvtepu8_epi16(_mm_loadu_si128(at)));
    }
  }

  static void store_means(std::uint8_t* to, V low, V high, V reciprocal) noexcept {
    // Packs each half by itself.
    const __m256i packed = _mm256_packus_epi16(mean(low, reciprocal), mean(high, reciprocal));
    avx2::store(to, as<u8x32>(_mm256_permute4x64_epi64(packed, 0b11'01'10'00)));
  }

 private:
  // The reciprocal is not negative, so nothing saturates.
  static __m256i mean(V sum, V reciprocal) noexcept {
    return _mm256_mulhrs_epi16(_mm256_srli_epi16(bits(sum), 1), bits(reciprocal));
  }
};

}  // namespace

void sum_along(std::span<const std::uint8_t> costs, int lanes,
               std::span<std::uint16_t> sums) noexcept {
  cross_aggregation_body::sum_along<Isa>(costs, lanes, sums);
}

void cross_means(std::span<const CrossEnds> ends, int lanes,
                 std::span<std::uint8_t> means) noexcept {
  if (lanes % static_cast<int>(2 * Isa::kLanes) != 0) {
    neon::cross_means(ends, lanes, means);
    return;
  }
  cross_aggregation_body::cross_means<Isa>(ends, lanes, means);
}

}  // namespace stof::dsp::avx2
