#include "dsp/stereo/search/path.h"

#include <cstddef>

#include "dsp/base/simd.h"
#include "dsp/base/simd_lowest.h"
#include "dsp/stereo/cost/sums_neon.h"
#include "dsp/stereo/search/path_body.h"

namespace stof::dsp::neon {
namespace {

using path_body::across;
using path_body::along;
using path_body::axes;
using path_body::both_ways;

uint8x16_t add_saturated(uint8x16_t a, uint8x16_t b) noexcept { return vqaddq_u8(a, b); }
uint16x8_t add_saturated(uint16x8_t a, uint16x8_t b) noexcept { return vqaddq_u16(a, b); }
uint32x4_t add_saturated(uint32x4_t a, uint32x4_t b) noexcept { return vqaddq_u32(a, b); }

// Lane i holds what was in lane i - 1 (the vector before ends the gap), or in lane i + 1.
uint8x16_t one_up(uint8x16_t before, uint8x16_t v) noexcept { return vextq_u8(before, v, 15); }
uint16x8_t one_up(uint16x8_t before, uint16x8_t v) noexcept { return vextq_u16(before, v, 7); }
uint32x4_t one_up(uint32x4_t before, uint32x4_t v) noexcept { return vextq_u32(before, v, 3); }
uint8x16_t one_down(uint8x16_t v, uint8x16_t after) noexcept { return vextq_u8(v, after, 1); }
uint16x8_t one_down(uint16x8_t v, uint16x8_t after) noexcept { return vextq_u16(v, after, 1); }
uint32x4_t one_down(uint32x4_t v, uint32x4_t after) noexcept { return vextq_u32(v, after, 1); }

uint8x16_t total(uint8x16_t a, uint8x16_t b) noexcept { return vqaddq_u8(a, b); }
uint16x8_t total(uint16x8_t a, uint16x8_t b) noexcept { return vaddq_u16(a, b); }

template <typename Sum>
struct Neon {
  using Cost = Sum;
  using V = typename Vector<Cost>::type;
  static constexpr std::size_t kLanes = Vector<Cost>::kLanes;

  static V load(const Cost* p) noexcept { return neon::load(p); }
  static void store(Cost* p, V v) noexcept { neon::store(p, v); }
  static V all(Cost v) noexcept { return neon::all(v); }
  static V smaller(V a, V b) noexcept { return neon::smaller(a, b); }
  static V sub(V a, V b) noexcept { return neon::sub(a, b); }
  static V add_saturated(V a, V b) noexcept { return neon::add_saturated(a, b); }
  static V total(V a, V b) noexcept { return neon::total(a, b); }
  static V one_up(V before, V v) noexcept { return neon::one_up(before, v); }
  static V one_down(V v, V after) noexcept { return neon::one_down(v, after); }
  static V lowest(V v) noexcept { return simd::smallest_everywhere(v); }
};

}  // namespace

void paths_from_left(std::span<const std::uint8_t> costs, int lanes, std::uint8_t small,
                     std::span<const std::uint8_t> large, std::span<std::uint8_t> paths) noexcept {
  along<Neon<std::uint8_t>>(costs, lanes, small, large, paths, true);
}
void paths_from_left(std::span<const std::uint16_t> costs, int lanes, std::uint16_t small,
                     std::span<const std::uint16_t> large,
                     std::span<std::uint16_t> paths) noexcept {
  along<Neon<std::uint16_t>>(costs, lanes, small, large, paths, true);
}
void paths_from_left(std::span<const std::uint32_t> costs, int lanes, std::uint32_t small,
                     std::span<const std::uint32_t> large,
                     std::span<std::uint32_t> paths) noexcept {
  along<Neon<std::uint32_t>>(costs, lanes, small, large, paths, true);
}
void paths_from_right(std::span<const std::uint8_t> costs, int lanes, std::uint8_t small,
                      std::span<const std::uint8_t> large, std::span<std::uint8_t> paths) noexcept {
  along<Neon<std::uint8_t>>(costs, lanes, small, large, paths, false);
}
void paths_from_right(std::span<const std::uint16_t> costs, int lanes, std::uint16_t small,
                      std::span<const std::uint16_t> large,
                      std::span<std::uint16_t> paths) noexcept {
  along<Neon<std::uint16_t>>(costs, lanes, small, large, paths, false);
}
void paths_from_right(std::span<const std::uint32_t> costs, int lanes, std::uint32_t small,
                      std::span<const std::uint32_t> large,
                      std::span<std::uint32_t> paths) noexcept {
  along<Neon<std::uint32_t>>(costs, lanes, small, large, paths, false);
}
void paths_both_ways(std::span<const std::uint8_t> costs, int lanes, std::uint8_t small,
                     std::span<const std::uint8_t> large_from_left,
                     std::span<const std::uint8_t> large_from_right,
                     std::span<std::uint8_t> from_left,
                     std::span<std::uint8_t> from_right) noexcept {
  both_ways<Neon<std::uint8_t>>(costs, lanes, small, large_from_left, large_from_right, from_left,
                                from_right);
}
void paths_both_ways(std::span<const std::uint16_t> costs, int lanes, std::uint16_t small,
                     std::span<const std::uint16_t> large_from_left,
                     std::span<const std::uint16_t> large_from_right,
                     std::span<std::uint16_t> from_left,
                     std::span<std::uint16_t> from_right) noexcept {
  both_ways<Neon<std::uint16_t>>(costs, lanes, small, large_from_left, large_from_right, from_left,
                                 from_right);
}
void paths_both_ways(std::span<const std::uint32_t> costs, int lanes, std::uint32_t small,
                     std::span<const std::uint32_t> large_from_left,
                     std::span<const std::uint32_t> large_from_right,
                     std::span<std::uint32_t> from_left,
                     std::span<std::uint32_t> from_right) noexcept {
  both_ways<Neon<std::uint32_t>>(costs, lanes, small, large_from_left, large_from_right, from_left,
                                 from_right);
}
void paths_across(std::span<const std::uint8_t> costs, std::span<const std::uint8_t> before,
                  int shift, int lanes, std::uint8_t small, std::span<const std::uint8_t> large,
                  std::span<std::uint8_t> paths) noexcept {
  across<Neon<std::uint8_t>>(costs, before, shift, lanes, small, large, paths);
}
void paths_across(std::span<const std::uint16_t> costs, std::span<const std::uint16_t> before,
                  int shift, int lanes, std::uint16_t small, std::span<const std::uint16_t> large,
                  std::span<std::uint16_t> paths) noexcept {
  across<Neon<std::uint16_t>>(costs, before, shift, lanes, small, large, paths);
}
void paths_across(std::span<const std::uint32_t> costs, std::span<const std::uint32_t> before,
                  int shift, int lanes, std::uint32_t small, std::span<const std::uint32_t> large,
                  std::span<std::uint32_t> paths) noexcept {
  across<Neon<std::uint32_t>>(costs, before, shift, lanes, small, large, paths);
}
void paths_of_axes(const AxesRow<std::uint8_t>& row, std::span<std::uint8_t> front,
                   std::span<const std::uint8_t> others, std::span<std::uint8_t> sums) noexcept {
  axes<Neon<std::uint8_t>>(row, front, others, sums);
}
void paths_of_axes(const AxesRow<std::uint16_t>& row, std::span<std::uint16_t> front,
                   std::span<const std::uint16_t> others, std::span<std::uint16_t> sums) noexcept {
  axes<Neon<std::uint16_t>>(row, front, others, sums);
}

}  // namespace stof::dsp::neon
