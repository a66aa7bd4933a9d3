#include "dsp/base/lanes_neon.h"
#include "dsp/stereo/cost/cross_aggregation_body.h"

namespace stof::dsp::neon {
namespace {

struct Isa : Lanes<std::uint8_t> {
  static V means(V a, V b, V c, std::int16_t reciprocal) noexcept {
    const uint16x8_t low = vaddw_u8(vaddl_u8(vget_low_u8(a), vget_low_u8(b)), vget_low_u8(c));
    const uint16x8_t high = vaddw_u8(vaddl_u8(vget_high_u8(a), vget_high_u8(b)), vget_high_u8(c));
    return vcombine_u8(clipped(low, reciprocal), clipped(high, reciprocal));
  }

 private:
  // The reciprocal is not negative, so nothing saturates but the mean.
  static uint8x8_t clipped(uint16x8_t sum, std::int16_t reciprocal) noexcept {
    return vqmovun_s16(simd::scaled_product(vreinterpretq_s16_u16(sum), vdupq_n_s16(reciprocal)));
  }
};

}  // namespace

void sum_alike(std::span<const std::uint8_t> costs, std::span<const std::uint8_t> joined, int lanes,
               std::span<std::uint8_t> sums) noexcept {
  cross_aggregation_body::sum_alike<Isa>(costs, joined, lanes, sums);
}

void cross_means(const CrossRows& rows, int lanes, std::span<std::uint8_t> means) noexcept {
  cross_aggregation_body::cross_means<Isa>(rows, lanes, means);
}

}  // namespace stof::dsp::neon
