#include "dsp/stereo/validation/winner_margin.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {
namespace {

// percent sum - 100 count c of one pixel.
std::int32_t lead_of(const std::uint8_t* costs, std::size_t lanes, std::uint8_t best,
                     int percent) noexcept {
  const uint8x16_t no_cost = vdupq_n_u8(kNoCost<std::uint8_t>);
  uint16x8_t sum = vdupq_n_u16(0);     // at most 256 / 8 * 254
  uint8x16_t offered = vdupq_n_u8(0);  // at most 256 / 16
  for (std::size_t i = 0; i < lanes; i += 16) {
    const uint8x16_t cost = vld1q_u8(costs + i);
    const uint8x16_t none = vceqq_u8(cost, no_cost);
    sum = vpadalq_u8(sum, vbicq_u8(cost, none));
    offered = vaddq_u8(offered, vaddq_u8(none, vdupq_n_u8(1)));  // a true mask is -1
  }
  return percent * static_cast<std::int32_t>(vaddlvq_u16(sum)) -
         100 * static_cast<std::int32_t>(vaddlvq_u8(offered)) * best;
}

// Below 100 * 256 * 2^16 < 2^31.
std::int32_t lead_of(const std::uint16_t* costs, std::size_t lanes, std::uint16_t best,
                     int percent) noexcept {
  const uint16x8_t no_cost = vdupq_n_u16(kNoCost<std::uint16_t>);
  uint32x4_t sum = vdupq_n_u32(0);
  uint16x8_t missing = vdupq_n_u16(0);  // counts down from 0
  for (std::size_t i = 0; i < lanes; i += 8) {
    const uint16x8_t cost = vld1q_u16(costs + i);
    const uint16x8_t none = vceqq_u16(cost, no_cost);
    sum = vpadalq_u16(sum, vbicq_u16(cost, none));
    missing = vaddq_u16(missing, none);
  }
  const std::int32_t count =
      static_cast<std::int32_t>(lanes) - static_cast<std::uint16_t>(-vaddvq_u16(missing));
  return percent * static_cast<std::int32_t>(vaddvq_u32(sum)) - 100 * count * best;
}

std::int64_t lead_of(const std::uint32_t* costs, std::size_t lanes, std::uint32_t best,
                     int percent) noexcept {
  const uint32x4_t no_cost = vdupq_n_u32(kNoCost<std::uint32_t>);
  uint64x2_t sum = vdupq_n_u64(0);
  uint32x4_t missing = vdupq_n_u32(0);
  for (std::size_t i = 0; i < lanes; i += 4) {
    const uint32x4_t cost = vld1q_u32(costs + i);
    const uint32x4_t none = vceqq_u32(cost, no_cost);
    sum = vpadalq_u32(sum, vbicq_u32(cost, none));
    missing = vaddq_u32(missing, none);
  }
  const std::int64_t count = static_cast<std::int64_t>(lanes) - (0U - vaddvq_u32(missing));
  return percent * static_cast<std::int64_t>(vaddvq_u64(sum)) - 100 * count * best;
}

// Eight margins from eight leads.
void store_margins(const std::array<std::int32_t, 8>& leads, int shift,
                   std::int16_t* out) noexcept {
  const int32x4_t right = vdupq_n_s32(-shift);
  const int16x8_t margins = vcombine_s16(vqmovn_s32(vshlq_s32(vld1q_s32(leads.data()), right)),
                                         vqmovn_s32(vshlq_s32(vld1q_s32(leads.data() + 4), right)));
  vst1q_s16(out, vmaxq_s16(margins, vdupq_n_s16(-32767)));
}
void store_margins(const std::array<std::int64_t, 8>& leads, int shift,
                   std::int16_t* out) noexcept {
  std::array<std::int32_t, 8> clipped{};
  for (std::size_t k = 0; k < 8; ++k) {
    clipped[k] =
        static_cast<std::int32_t>(std::clamp<std::int64_t>(leads[k] >> shift, -32767, 32767));
  }
  store_margins(clipped, 0, out);
}

}  // namespace

template <typename Sum>
void winner_margins(std::span<const Sum> costs, int lanes, std::span<const std::int16_t> winners,
                    int percent, int shift, std::span<std::int16_t> margins) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  const std::size_t n = winners.size();
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && lanes <= 256 && shift >= 0 &&
             shift <= 30 && costs.size() == n * count && margins.size() == n);
  std::size_t x = 0;
  for (; x + 8 <= n; x += 8) {
    std::array<decltype(lead_of(costs.data(), count, Sum{}, percent)), 8> leads{};
    for (std::size_t k = 0; k < 8; ++k) {
      const std::int16_t winner = winners[x + k];
      const Sum* const pixel = costs.data() + (x + k) * count;
      if (winner != kNoWinner && pixel[winner] != kNoCost<Sum>) {
        leads[k] = lead_of(pixel, count, pixel[winner], percent);
      }
    }
    store_margins(leads, shift, margins.data() + x);
  }
  ref::winner_margins(costs.subspan(x * count), lanes, winners.subspan(x), percent, shift,
                      margins.subspan(x));
}

STOF_INSTANTIATE(WinnerMargins, winner_margins, std::uint8_t, std::uint16_t, std::uint32_t);

}  // namespace stof::dsp::neon
