#include "dsp/base/lanes_neon.h"
#include "dsp/stereo/cost/cross_aggregation_body.h"

namespace stof::dsp::neon {
namespace {

struct Isa : Lanes<std::uint16_t> {
  template <std::size_t kVectors>
  static void add_bytes(const std::uint8_t* costs, V (&sums)[kVectors]) noexcept {
    if constexpr (kVectors == 1) {
      sums[0] = vaddw_u8(sums[0], vld1_u8(costs));
    } else {
      for (std::size_t v = 0; v < kVectors; v += 2) {
        const uint8x16_t some = vld1q_u8(costs + v * kLanes);
        sums[v] = vaddw_u8(sums[v], vget_low_u8(some));
        sums[v + 1] = vaddw_u8(sums[v + 1], vget_high_u8(some));
      }
    }
  }

  static void store_means(std::uint8_t* to, V low, V high, V reciprocal) noexcept {
    vst1q_u8(to, vcombine_u8(clipped(low, reciprocal), clipped(high, reciprocal)));
  }

 private:
  // The reciprocal is not negative, so nothing saturates but the mean.
  static uint8x8_t clipped(V sum, V reciprocal) noexcept {
    return vqmovun_s16(simd::scaled_product(vreinterpretq_s16_u16(vshrq_n_u16(sum, 1)),
                                            vreinterpretq_s16_u16(reciprocal)));
  }
};

}  // namespace

void sum_along(std::span<const std::uint8_t> costs, int lanes,
               std::span<std::uint16_t> sums) noexcept {
  cross_aggregation_body::sum_along<Isa>(costs, lanes, sums);
}

void cross_means(std::span<const CrossEnds> ends, int lanes,
                 std::span<std::uint8_t> means) noexcept {
  cross_aggregation_body::cross_means<Isa>(ends, lanes, means);
}

}  // namespace stof::dsp::neon
