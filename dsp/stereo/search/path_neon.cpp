#include "dsp/stereo/search/path.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"
#include "dsp/stereo/cost/sums_neon.h"

namespace stof::dsp::neon {
namespace {

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

// kVectors vectors of candidates, or, where it is 0, as many as `lanes` holds: a known count is
// unrolled. Along a row each pixel waits for the minimum of the one before, so that the minimum is
// formed from registers while the pixel is stored; the paths themselves come back from L1 sooner
// than the minimum is known.
template <typename Cost, std::size_t kVectors>
class Step {
 public:
  using V = typename Vector<Cost>::type;
  static constexpr std::size_t kStep = Vector<Cost>::kLanes;

  Step(int lanes, Cost small) noexcept
      : vectors_(kVectors != 0 ? kVectors : static_cast<std::size_t>(lanes) / kStep),
        small_(all(small)) {}

  std::size_t lanes() const noexcept { return vectors_ * kStep; }

  // The lowest in every lane.
  V lowest(const Cost* paths) const noexcept {
    V least = load(paths);
    for (std::size_t v = 1; v < vectors_; ++v) {
      least = smaller(least, load(paths + v * kStep));
    }
    return simd::smallest_everywhere(least);
  }

  // A pixel with none before it.
  V start(const Cost* costs, Cost* paths) const noexcept {
    for (std::size_t v = 0; v < vectors_; ++v) {
      store(paths + v * kStep, load(costs + v * kStep));
    }
    return lowest(paths);
  }

  // lowest: of `before`, in every lane. Returns that of paths.
  V go(const Cost* costs, const Cost* before, V lowest, Cost large, Cost* paths) const noexcept {
    const V jump = add_saturated(lowest, all(large));
    V previous = all(kNoCost<Cost>);
    V here = load(before);
    V least = all(kNoCost<Cost>);
    for (std::size_t v = 0; v < vectors_; ++v) {
      const V next = v + 1 < vectors_ ? load(before + (v + 1) * kStep) : all(kNoCost<Cost>);
      const V neighbours = smaller(one_up(previous, here), one_down(here, next));
      const V best = smaller(smaller(here, add_saturated(neighbours, small_)), jump);
      const V path = add_saturated(load(costs + v * kStep), sub(best, lowest));
      store(paths + v * kStep, path);
      least = smaller(least, path);
      previous = here;
      here = next;
    }
    return simd::smallest_everywhere(least);
  }

 private:
  std::size_t vectors_;
  V small_;
};

template <typename Cost, std::size_t kVectors>
void walk(std::span<const Cost> costs, int lanes, Cost small, std::span<const Cost> large,
          std::span<Cost> paths, bool from_left) noexcept {
  const Step<Cost, kVectors> step(lanes, small);
  const std::size_t n = large.size();
  const std::size_t count = step.lanes();
  const std::size_t first = from_left ? 0 : n - 1;
  std::size_t before = first * count;
  auto lowest = step.start(costs.data() + before, paths.data() + before);
  for (std::size_t k = 1; k < n; ++k) {
    const std::size_t x = from_left ? k : n - 1 - k;
    lowest = step.go(costs.data() + x * count, paths.data() + before, lowest, large[x],
                     paths.data() + x * count);
    before = x * count;
  }
}

// The two ways do not wait for each other: what one waits for is the other's time.
template <typename Cost, std::size_t kVectors>
void walk_both(std::span<const Cost> costs, int lanes, Cost small,
               std::span<const Cost> large_from_left, std::span<const Cost> large_from_right,
               std::span<Cost> from_left, std::span<Cost> from_right) noexcept {
  const Step<Cost, kVectors> step(lanes, small);
  const std::size_t n = large_from_left.size();
  const std::size_t count = step.lanes();
  std::size_t left = 0;
  std::size_t right = (n - 1) * count;
  auto left_lowest = step.start(costs.data() + left, from_left.data() + left);
  auto right_lowest = step.start(costs.data() + right, from_right.data() + right);
  for (std::size_t k = 1; k < n; ++k) {
    left_lowest = step.go(costs.data() + left + count, from_left.data() + left, left_lowest,
                          large_from_left[k], from_left.data() + left + count);
    right_lowest = step.go(costs.data() + right - count, from_right.data() + right, right_lowest,
                           large_from_right[n - 1 - k], from_right.data() + right - count);
    left += count;
    right -= count;
  }
}

template <typename Cost, std::size_t kVectors>
void cross(std::span<const Cost> costs, std::span<const Cost> before, int shift, int lanes,
           Cost small, std::span<const Cost> large, std::span<Cost> paths) noexcept {
  const Step<Cost, kVectors> step(lanes, small);
  const std::size_t count = step.lanes();
  const int n = static_cast<int>(large.size());
  for (int x = 0; x < n; ++x) {
    const std::size_t at = static_cast<std::size_t>(x) * count;
    if (x - shift < 0 || x - shift >= n) {
      step.start(costs.data() + at, paths.data() + at);
      continue;
    }
    const Cost* const from = before.data() + static_cast<std::size_t>(x - shift) * count;
    step.go(costs.data() + at, from, step.lowest(from), large[static_cast<std::size_t>(x)],
            paths.data() + at);
  }
}

template <typename Cost>
void along(std::span<const Cost> costs, int lanes, Cost small, std::span<const Cost> large,
           std::span<Cost> paths, bool from_left) noexcept {
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && paths.size() == costs.size() &&
             costs.size() == large.size() * static_cast<std::size_t>(lanes));
  if (large.empty()) {
    return;
  }
  switch (static_cast<std::size_t>(lanes) / Vector<Cost>::kLanes) {
    case 4:
      return walk<Cost, 4>(costs, lanes, small, large, paths, from_left);
    case 8:
      return walk<Cost, 8>(costs, lanes, small, large, paths, from_left);
    default:
      return walk<Cost, 0>(costs, lanes, small, large, paths, from_left);
  }
}

template <typename Cost>
void both(std::span<const Cost> costs, int lanes, Cost small, std::span<const Cost> large_from_left,
          std::span<const Cost> large_from_right, std::span<Cost> from_left,
          std::span<Cost> from_right) noexcept {
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && from_left.size() == costs.size() &&
             from_right.size() == costs.size() &&
             large_from_right.size() == large_from_left.size() &&
             costs.size() == large_from_left.size() * static_cast<std::size_t>(lanes));
  if (large_from_left.empty()) {
    return;
  }
  switch (static_cast<std::size_t>(lanes) / Vector<Cost>::kLanes) {
    case 4:
      return walk_both<Cost, 4>(costs, lanes, small, large_from_left, large_from_right, from_left,
                                from_right);
    case 8:
      return walk_both<Cost, 8>(costs, lanes, small, large_from_left, large_from_right, from_left,
                                from_right);
    default:
      return walk_both<Cost, 0>(costs, lanes, small, large_from_left, large_from_right, from_left,
                                from_right);
  }
}

template <typename Cost>
void across(std::span<const Cost> costs, std::span<const Cost> before, int shift, int lanes,
            Cost small, std::span<const Cost> large, std::span<Cost> paths) noexcept {
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && shift >= -1 && shift <= 1);
  STOF_CHECK(costs.size() == large.size() * static_cast<std::size_t>(lanes) &&
             before.size() == costs.size() && paths.size() == costs.size());
  switch (static_cast<std::size_t>(lanes) / Vector<Cost>::kLanes) {
    case 4:
      return cross<Cost, 4>(costs, before, shift, lanes, small, large, paths);
    case 8:
      return cross<Cost, 8>(costs, before, shift, lanes, small, large, paths);
    default:
      return cross<Cost, 0>(costs, before, shift, lanes, small, large, paths);
  }
}

}  // namespace

void paths_from_left(std::span<const std::uint8_t> costs, int lanes, std::uint8_t small,
                     std::span<const std::uint8_t> large, std::span<std::uint8_t> paths) noexcept {
  along(costs, lanes, small, large, paths, true);
}
void paths_from_left(std::span<const std::uint16_t> costs, int lanes, std::uint16_t small,
                     std::span<const std::uint16_t> large,
                     std::span<std::uint16_t> paths) noexcept {
  along(costs, lanes, small, large, paths, true);
}
void paths_from_left(std::span<const std::uint32_t> costs, int lanes, std::uint32_t small,
                     std::span<const std::uint32_t> large,
                     std::span<std::uint32_t> paths) noexcept {
  along(costs, lanes, small, large, paths, true);
}
void paths_from_right(std::span<const std::uint8_t> costs, int lanes, std::uint8_t small,
                      std::span<const std::uint8_t> large, std::span<std::uint8_t> paths) noexcept {
  along(costs, lanes, small, large, paths, false);
}
void paths_from_right(std::span<const std::uint16_t> costs, int lanes, std::uint16_t small,
                      std::span<const std::uint16_t> large,
                      std::span<std::uint16_t> paths) noexcept {
  along(costs, lanes, small, large, paths, false);
}
void paths_from_right(std::span<const std::uint32_t> costs, int lanes, std::uint32_t small,
                      std::span<const std::uint32_t> large,
                      std::span<std::uint32_t> paths) noexcept {
  along(costs, lanes, small, large, paths, false);
}
void paths_both_ways(std::span<const std::uint8_t> costs, int lanes, std::uint8_t small,
                     std::span<const std::uint8_t> large_from_left,
                     std::span<const std::uint8_t> large_from_right,
                     std::span<std::uint8_t> from_left,
                     std::span<std::uint8_t> from_right) noexcept {
  both(costs, lanes, small, large_from_left, large_from_right, from_left, from_right);
}
void paths_both_ways(std::span<const std::uint16_t> costs, int lanes, std::uint16_t small,
                     std::span<const std::uint16_t> large_from_left,
                     std::span<const std::uint16_t> large_from_right,
                     std::span<std::uint16_t> from_left,
                     std::span<std::uint16_t> from_right) noexcept {
  both(costs, lanes, small, large_from_left, large_from_right, from_left, from_right);
}
void paths_both_ways(std::span<const std::uint32_t> costs, int lanes, std::uint32_t small,
                     std::span<const std::uint32_t> large_from_left,
                     std::span<const std::uint32_t> large_from_right,
                     std::span<std::uint32_t> from_left,
                     std::span<std::uint32_t> from_right) noexcept {
  both(costs, lanes, small, large_from_left, large_from_right, from_left, from_right);
}
void paths_across(std::span<const std::uint8_t> costs, std::span<const std::uint8_t> before,
                  int shift, int lanes, std::uint8_t small, std::span<const std::uint8_t> large,
                  std::span<std::uint8_t> paths) noexcept {
  across(costs, before, shift, lanes, small, large, paths);
}
void paths_across(std::span<const std::uint16_t> costs, std::span<const std::uint16_t> before,
                  int shift, int lanes, std::uint16_t small, std::span<const std::uint16_t> large,
                  std::span<std::uint16_t> paths) noexcept {
  across(costs, before, shift, lanes, small, large, paths);
}
void paths_across(std::span<const std::uint32_t> costs, std::span<const std::uint32_t> before,
                  int shift, int lanes, std::uint32_t small, std::span<const std::uint32_t> large,
                  std::span<std::uint32_t> paths) noexcept {
  across(costs, before, shift, lanes, small, large, paths);
}

}  // namespace stof::dsp::neon
