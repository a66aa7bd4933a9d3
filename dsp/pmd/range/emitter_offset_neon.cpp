#include "dsp/pmd/range/emitter_offset.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"
#include "dsp/pmd/range/phase_to_distance.h"

namespace stof::dsp::neon {
namespace {

constexpr std::size_t kLanes = 4;

// What the three tables say about four pixels.
struct Lights {
  int32x4_t half_q2;
  int32x4_t twice_area;
  int32x4_t pole;
};

uint32x4_t corrected(uint32x4_t distance, int32x4_t shortest, const Lights& lights) noexcept {
  const uint32x4_t measured = vminq_u32(distance, vdupq_n_u32(kMostUnits));
  const int32x4_t way = vmaxq_s32(vreinterpretq_s32_u32(vaddq_u32(measured, measured)), shortest);
  const int32x4_t free_way = vmaxq_s32(vsubq_s32(way, lights.pole), vdupq_n_s32(1));
  const float32x4_t bend = simd::divide(vcvtq_f32_s32(lights.twice_area), vcvtq_f32_s32(free_way));
  const float32x4_t limited =
      vminq_f32(vmaxq_f32(bend, vdupq_n_f32(-1048576.0F)), vdupq_n_f32(1048576.0F));
  // round_to_int also holds for numbers from -2^22 on: 1.5 * 2^23 leaves room on both sides.
  const int32x4_t quarters =
      vsubq_s32(vaddq_s32(vreinterpretq_s32_u32(vshlq_n_u32(measured, 2)), lights.half_q2),
                simd::round_to_int(limited));
  return vreinterpretq_u32_s32(vmaxq_s32(vrshrq_n_s32(quarters, 2), vdupq_n_s32(1)));
}

}  // namespace

void emitter_offset(const EmitterOffsetRow& table, std::uint32_t shortest,
                    std::span<std::uint32_t> distance) noexcept {
  const std::size_t n = distance.size();
  STOF_CHECK(table.half_q2.size() == n && table.twice_area.size() == n && table.pole.size() == n);
  STOF_CHECK(shortest <= 2 * kMostUnits);
  const int32x4_t least = vdupq_n_s32(static_cast<std::int32_t>(shortest));
  std::size_t x = 0;
  for (; x + kLanes <= n; x += kLanes) {
    const Lights lights{vmovl_s16(vld1_s16(table.half_q2.data() + x)),
                        vld1q_s32(table.twice_area.data() + x), vld1q_s32(table.pole.data() + x)};
    vst1q_u32(distance.data() + x, corrected(vld1q_u32(distance.data() + x), least, lights));
  }
  ref::emitter_offset(
      {table.half_q2.subspan(x), table.twice_area.subspan(x), table.pole.subspan(x)}, shortest,
      distance.subspan(x));
}

}  // namespace stof::dsp::neon
