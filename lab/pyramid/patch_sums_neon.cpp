#include "lab/pyramid/patch_sums.h"

#include <array>

#include "dsp/base/simd.h"
#include "lab/pyramid/patch_find_body.h"
#include "lab/pyramid/patch_quarter_body.h"
#include "lab/pyramid/patch_sums_body.h"

namespace stof::dsp::neon {
namespace {

constexpr std::array<std::int16_t, 8> kPlaces{0, 1, 2, 3, 4, 5, 6, 7};

// What patch_boxes_body.h and patch_quarter_body.h ask for.
struct Neon {
  using Bytes = uint8x16_t;
  using Sums = uint16x8_t;
  static constexpr std::size_t kBytes = 16;

  static Bytes load_bytes(const std::uint8_t* p) noexcept { return vld1q_u8(p); }
  static void store_bytes(std::uint8_t* p, Bytes v) noexcept { vst1q_u8(p, v); }
  static Bytes difference(Bytes a, Bytes b) noexcept { return vabdq_u8(a, b); }
  static Bytes zero() noexcept { return vdupq_n_u8(0); }
  static Bytes plus(Bytes a, Bytes b) noexcept { return vaddq_u8(a, b); }
  static Bytes minus(Bytes a, Bytes b) noexcept { return vsubq_u8(a, b); }
  static Sums low(Bytes v) noexcept { return vmovl_u8(vget_low_u8(v)); }
  static Sums high(Bytes v) noexcept { return vmovl_u8(vget_high_u8(v)); }
  static Sums widen(const std::uint8_t* p) noexcept {
    return vreinterpretq_u16_s16(vmovl_s8(vreinterpret_s8_u8(vld1_u8(p))));
  }
  static Sums all(std::uint16_t v) noexcept { return vdupq_n_u16(v); }
  static Sums load(const std::uint16_t* p) noexcept { return vld1q_u16(p); }
  static void store(std::uint16_t* p, Sums v) noexcept { vst1q_u16(p, v); }
  static Sums add(Sums a, Sums b) noexcept { return vaddq_u16(a, b); }
  static Sums subtract(Sums a, Sums b) noexcept { return vsubq_u16(a, b); }
  static void sixteens(const std::uint8_t* p, Sums& low, Sums& high) noexcept {
    const auto at = [&](std::size_t x) noexcept { return vreinterpretq_s8_u8(vld1q_u8(p + x)); };
    const int16x8_t even = vpadalq_s8(vpaddlq_s8(at(0)), at(8));
    const int16x8_t odd = vpadalq_s8(vpaddlq_s8(at(1)), at(9));
    low = times8(vreinterpretq_u16_s16(vzip1q_s16(even, odd)));
    high = times8(vreinterpretq_u16_s16(vzip2q_s16(even, odd)));
  }
  static Sums times8(Sums v) noexcept { return vshlq_n_u16(v, 3); }
  static Sums eighth(Sums v) noexcept { return vshrq_n_u16(v, 3); }
  static Sums low_bits(Sums v) noexcept { return vandq_u16(v, vdupq_n_u16(7)); }
  static Sums smaller(Sums a, Sums b) noexcept { return vminq_u16(a, b); }
  static Sums less(Sums a, Sums b) noexcept { return vcltq_u16(a, b); }
  static Sums equal(Sums a, Sums b) noexcept { return vceqq_u16(a, b); }
  static Sums both(Sums a, Sums b) noexcept { return vandq_u16(a, b); }
  static Sums either(Sums a, Sums b) noexcept { return vorrq_u16(a, b); }
  static bool any(Sums mask) noexcept {
    return vgetq_lane_u64(vreinterpretq_u64_u16(mask), 0) != 0 ||
           vgetq_lane_u64(vreinterpretq_u64_u16(mask), 1) != 0;
  }
  static Sums select(Sums mask, Sums a, Sums b) noexcept { return vbslq_u16(mask, a, b); }
  // Which lanes lie in begin .. end - 1.
  static Sums between(int begin, int end) noexcept {
    const int16x8_t lane = vld1q_s16(kPlaces.data());
    return vandq_u16(vcgeq_s16(lane, vdupq_n_s16(static_cast<std::int16_t>(begin))),
                     vcltq_s16(lane, vdupq_n_s16(static_cast<std::int16_t>(end))));
  }

  static Sums greater(Sums a, Sums b) noexcept { return vmaxq_u16(a, b); }
  static Sums pairs(Bytes v) noexcept {
    return times8(vreinterpretq_u16_s16(vpaddlq_s8(vreinterpretq_s8_u8(v))));
  }
  static Sums firsts(Bytes v) noexcept {
    return vreinterpretq_u16_s16(vshrq_n_s16(vshlq_n_s16(vreinterpretq_s16_u8(v), 8), 5));
  }
  static Sums seconds(Bytes v) noexcept {
    return times8(vreinterpretq_u16_s16(vshrq_n_s16(vreinterpretq_s16_u8(v), 8)));
  }
  template <int kBy>
  static Sums after(Sums a, Sums b) noexcept {
    return vextq_u16(a, b, kBy);
  }
  template <int kBy>
  static Bytes after(Bytes a, Bytes b) noexcept {
    return vextq_u8(a, b, 2 * kBy);
  }
};

}  // namespace

void start_patch(const PatchPlace& patch, Rows rows, std::span<std::uint16_t> sums) noexcept {
  patch_sums_body::start<Neon>(patch, rows, sums);
}
void slide_patch(const PatchPlace& patch, int entering, int leaving,
                 std::span<std::uint16_t> sums) noexcept {
  patch_sums_body::slide<Neon>(patch, entering, leaving, sums);
}
void find_in_patch(std::span<const std::uint16_t> sums, std::span<const std::int16_t> candidates,
                   const PatchLimits& limits, std::span<std::int16_t> winners) noexcept {
  patch_sums_body::find<Neon>(sums, candidates, limits, winners);
}
void offer_to_right(std::span<const std::uint16_t> sums, std::int16_t candidate,
                    std::span<std::uint16_t> lowest, std::span<std::int16_t> winners) noexcept {
  patch_sums_body::offer<Neon>(sums, candidate, lowest, winners);
}
void find_quarter(const PatchPlace& patch, Rows rows, int block_height, const PatchLimits& limits,
                  ImageView<std::int16_t> winners) noexcept {
  patch_quarter_body::find_quarter<Neon>(patch, rows, block_height, limits, winners);
}

}  // namespace stof::dsp::neon
