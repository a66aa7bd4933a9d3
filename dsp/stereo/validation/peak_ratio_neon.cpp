#include "dsp/stereo/validation/peak_ratio.h"

#include <array>
#include <cstddef>
#include <cstring>

#include "dsp/base/lanes_neon.h"
#include "dsp/stereo/validation/peak_ratio_body.h"

namespace stof::dsp::neon {
namespace {

// Four pixels, a lane each.
uint32x4_t four(const std::uint8_t* p) noexcept {
  std::uint32_t bytes = 0;
  std::memcpy(&bytes, p, sizeof bytes);
  return vmovl_u16(vget_low_u16(vmovl_u8(vreinterpret_u8_u32(vdup_n_u32(bytes)))));
}
uint32x4_t four(const std::uint16_t* p) noexcept { return vmovl_u16(vld1_u16(p)); }
uint32x4_t four(const std::uint32_t* p) noexcept { return vld1q_u32(p); }

template <typename Sum>
struct Peaks {
  using L = Lanes<Sum>;

  static Sum lowest(const Sum* costs, const Sum* near, std::size_t count) noexcept {
    auto least = L::load(costs) | L::load(near);
    for (std::size_t i = L::kLanes; i < count; i += L::kLanes) {
      least = L::smaller(least, L::load(costs + i) | L::load(near + i));
    }
    return L::smallest(least);
  }

  static void put_ratios(const Sum* own, const Sum* rival, int shift, std::uint8_t* to) noexcept {
    const int32x4_t down = vdupq_n_s32(-shift);
    std::array<uint16x8_t, 2> ratios{};
    for (std::size_t k = 0; k < 2; ++k) {
      const uint32x4_t low = ratio(four(own + 8 * k), four(rival + 8 * k), down);
      const uint32x4_t high = ratio(four(own + 8 * k + 4), four(rival + 8 * k + 4), down);
      ratios[k] = vcombine_u16(vmovn_u32(low), vmovn_u32(high));
    }
    vst1q_u8(to, vcombine_u8(vmovn_u16(ratios[0]), vmovn_u16(ratios[1])));
  }

 private:
  // Its lowest byte.
  static uint32x4_t ratio(uint32x4_t own, uint32x4_t rival, int32x4_t down) noexcept {
    const uint32x4_t none = vceqq_u32(rival, vdupq_n_u32(kNoCost<Sum>));
    const uint32x4_t c = vshlq_u32(own, down);
    const uint32x4_t r = vshlq_u32(vbicq_u32(rival, none), down);
    const float32x4_t scaled = vmulq_f32(vdupq_n_f32(255.0F), vcvtq_f32_u32(c));
    return vorrq_u32(vcvtq_u32_f32(simd::divide(scaled, vcvtq_f32_u32(r))), vcgeq_u32(c, r));
  }
};

}  // namespace

template <typename Sum>
void peak_ratio(std::span<const Sum> costs, int lanes, bool numbered,
                std::span<const std::int16_t> winners, std::span<std::uint8_t> ratio) noexcept {
  const std::size_t x =
      peak_ratio_body::Ratios<Peaks<Sum>, Sum>::find(costs, lanes, numbered, winners, ratio);
  ref::peak_ratio(costs.subspan(x * static_cast<std::size_t>(lanes)), lanes, numbered,
                  winners.subspan(x), ratio.subspan(x));
}

STOF_INSTANTIATE(PeakRatio, peak_ratio, std::uint8_t, std::uint16_t, std::uint32_t);

}  // namespace stof::dsp::neon
