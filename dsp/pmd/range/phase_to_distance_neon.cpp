#include "dsp/pmd/range/phase_to_distance.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {
namespace {

constexpr std::size_t kLanes = 4;
constexpr std::uint32_t kShortTurn = 65535;  // phase * turn fits 32 bits up to here

uint32x4_t turned(uint16x4_t phase, std::uint32_t turn) noexcept {
  const uint32x4_t wide = vmovl_u16(phase);
  const uint32x2_t k = vdup_n_u32(turn);
  return vcombine_u32(vrshrn_n_u64(vmull_u32(vget_low_u32(wide), k), 16),
                      vrshrn_n_u64(vmull_u32(vget_high_u32(wide), k), 16));
}

uint32x4_t turned_short(uint16x4_t phase, uint16x4_t turn) noexcept {
  return vrshrq_n_u32(vmull_u16(phase, turn), 16);
}

uint32x4_t on_line(uint32x4_t distance, const LinearDistanceCorrection& line) noexcept {
  const uint32x4_t most = vdupq_n_u32(kMostUnits);
  const uint32x4_t d = vminq_u32(distance, most);
  const uint32x2_t scale = vdup_n_u32(line.scale_q15);
  // At most 2^30, with the shift at most 2^30 + 2^28: signed arithmetic does not overflow.
  const uint32x4_t stretched = vcombine_u32(vrshrn_n_u64(vmull_u32(vget_low_u32(d), scale), 15),
                                            vrshrn_n_u64(vmull_u32(vget_high_u32(d), scale), 15));
  int32x4_t z = vaddq_s32(vreinterpretq_s32_u32(stretched), vdupq_n_s32(line.shift));
  const uint32x4_t behind = vcleq_s32(z, vdupq_n_s32(0));
  z = vaddq_s32(z, vreinterpretq_s32_u32(vandq_u32(behind, vdupq_n_u32(line.turn))));
  const int32x4_t limit = vreinterpretq_s32_u32(most);
  return vreinterpretq_u32_s32(vminq_s32(vmaxq_s32(z, vdupq_n_s32(1)), limit));
}

}  // namespace

void phase_to_distance(std::span<const Phase> phase, std::uint32_t turn,
                       std::span<std::uint32_t> distance) noexcept {
  STOF_CHECK(distance.size() == phase.size() && turn <= kMostUnits);
  std::size_t x = 0;
  if (turn <= kShortTurn) {
    const uint16x4_t k = vdup_n_u16(static_cast<std::uint16_t>(turn));
    for (; x + kLanes <= phase.size(); x += kLanes) {
      vst1q_u32(distance.data() + x, turned_short(vld1_u16(phase.data() + x), k));
    }
  } else {
    for (; x + kLanes <= phase.size(); x += kLanes) {
      vst1q_u32(distance.data() + x, turned(vld1_u16(phase.data() + x), turn));
    }
  }
  ref::phase_to_distance(phase.subspan(x), turn, distance.subspan(x));
}

void correct_distance(const LinearDistanceCorrection& line,
                      std::span<std::uint32_t> distance) noexcept {
  STOF_CHECK(usable(line));
  std::size_t x = 0;
  for (; x + kLanes <= distance.size(); x += kLanes) {
    vst1q_u32(distance.data() + x, on_line(vld1q_u32(distance.data() + x), line));
  }
  ref::correct_distance(line, distance.subspan(x));
}

}  // namespace stof::dsp::neon
