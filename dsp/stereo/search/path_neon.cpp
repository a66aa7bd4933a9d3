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
struct Lanes {
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

template <typename Cost>
void paths_from_left(std::span<const Cost> costs, int lanes, Cost small,
                     std::span<const Cost> large, std::span<Cost> paths) noexcept {
  along<Lanes<Cost>>(costs, lanes, small, large, paths, true);
}

template <typename Cost>
void paths_from_right(std::span<const Cost> costs, int lanes, Cost small,
                      std::span<const Cost> large, std::span<Cost> paths) noexcept {
  along<Lanes<Cost>>(costs, lanes, small, large, paths, false);
}

template <typename Cost>
void paths_both_ways(std::span<const Cost> costs, int lanes, Cost small,
                     std::span<const Cost> large_from_left, std::span<const Cost> large_from_right,
                     std::span<Cost> from_left, std::span<Cost> from_right) noexcept {
  both_ways<Lanes<Cost>>(costs, lanes, small, large_from_left, large_from_right, from_left,
                        from_right);
}

template <typename Cost>
void paths_across(std::span<const Cost> costs, std::span<const Cost> before, int shift, int lanes,
                  Cost small, std::span<const Cost> large, std::span<Cost> paths) noexcept {
  across<Lanes<Cost>>(costs, before, shift, lanes, small, large, paths);
}

template <typename Cost>
void paths_of_axes(const AxesRow<Cost>& row, std::span<Cost> front, std::span<const Cost> others,
                   std::span<Cost> sums) noexcept {
  axes<Lanes<Cost>>(row, front, others, sums);
}

template PathsAlong<std::uint8_t> paths_from_left<std::uint8_t>;
template PathsAlong<std::uint16_t> paths_from_left<std::uint16_t>;
template PathsAlong<std::uint32_t> paths_from_left<std::uint32_t>;
template PathsAlong<std::uint8_t> paths_from_right<std::uint8_t>;
template PathsAlong<std::uint16_t> paths_from_right<std::uint16_t>;
template PathsAlong<std::uint32_t> paths_from_right<std::uint32_t>;
template PathsBothWays<std::uint8_t> paths_both_ways<std::uint8_t>;
template PathsBothWays<std::uint16_t> paths_both_ways<std::uint16_t>;
template PathsBothWays<std::uint32_t> paths_both_ways<std::uint32_t>;
template PathsAcross<std::uint8_t> paths_across<std::uint8_t>;
template PathsAcross<std::uint16_t> paths_across<std::uint16_t>;
template PathsAcross<std::uint32_t> paths_across<std::uint32_t>;
template PathsOfAxes<std::uint8_t> paths_of_axes<std::uint8_t>;
template PathsOfAxes<std::uint16_t> paths_of_axes<std::uint16_t>;

}  // namespace stof::dsp::neon
