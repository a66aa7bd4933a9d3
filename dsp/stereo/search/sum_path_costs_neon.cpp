#include "dsp/stereo/search/sum_path_costs.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {
namespace {

void sum_two(const std::uint8_t* a, const std::uint8_t* b, uint16x8_t& low,
             uint16x8_t& high) noexcept {
  const uint8x16_t first = vld1q_u8(a);
  const uint8x16_t second = vld1q_u8(b);
  low = vaddl_u8(vget_low_u8(first), vget_low_u8(second));
  high = vaddl_u8(vget_high_u8(first), vget_high_u8(second));
}

// Four directions are what frames are matched with: all at once, nothing looped over.
void sum_four(std::span<const std::uint8_t* const> paths, std::span<std::uint16_t> sums) noexcept {
  for (std::size_t i = 0; i < sums.size(); i += 16) {
    uint16x8_t low_a;
    uint16x8_t high_a;
    uint16x8_t low_b;
    uint16x8_t high_b;
    sum_two(paths[0] + i, paths[1] + i, low_a, high_a);
    sum_two(paths[2] + i, paths[3] + i, low_b, high_b);
    vst1q_u16(sums.data() + i, vaddq_u16(low_a, low_b));
    vst1q_u16(sums.data() + i + 8, vaddq_u16(high_a, high_b));
  }
}

void add_up(std::span<const std::uint8_t* const> paths, std::span<std::uint8_t> sums) noexcept {
  STOF_CHECK(paths.size() >= 2 && sums.size() % 16 == 0);
  if (paths.size() == 4) {
    for (std::size_t i = 0; i < sums.size(); i += 16) {
      const uint8x16_t a = vqaddq_u8(vld1q_u8(paths[0] + i), vld1q_u8(paths[1] + i));
      const uint8x16_t b = vqaddq_u8(vld1q_u8(paths[2] + i), vld1q_u8(paths[3] + i));
      vst1q_u8(sums.data() + i, vqaddq_u8(a, b));
    }
    return;
  }
  for (std::size_t i = 0; i < sums.size(); i += 16) {
    uint8x16_t total = vqaddq_u8(vld1q_u8(paths[0] + i), vld1q_u8(paths[1] + i));
    for (const std::uint8_t* const path : paths.subspan(2)) {
      total = vqaddq_u8(total, vld1q_u8(path + i));
    }
    vst1q_u8(sums.data() + i, total);
  }
}

void add_up(std::span<const std::uint8_t* const> paths, std::span<std::uint16_t> sums) noexcept {
  STOF_CHECK(paths.size() >= 2 && sums.size() % 16 == 0);
  if (paths.size() == 4) {
    sum_four(paths, sums);
    return;
  }
  for (std::size_t i = 0; i < sums.size(); i += 16) {
    uint16x8_t low;
    uint16x8_t high;
    sum_two(paths[0] + i, paths[1] + i, low, high);
    for (const std::uint8_t* const path : paths.subspan(2)) {
      const uint8x16_t v = vld1q_u8(path + i);
      low = vaddw_u8(low, vget_low_u8(v));
      high = vaddw_u8(high, vget_high_u8(v));
    }
    vst1q_u16(sums.data() + i, low);
    vst1q_u16(sums.data() + i + 8, high);
  }
}

void add_up(std::span<const std::uint16_t* const> paths, std::span<std::uint16_t> sums) noexcept {
  STOF_CHECK(paths.size() >= 2 && sums.size() % 16 == 0);
  for (std::size_t i = 0; i < sums.size(); i += 8) {
    uint16x8_t total = vaddq_u16(vld1q_u16(paths[0] + i), vld1q_u16(paths[1] + i));
    for (const std::uint16_t* const path : paths.subspan(2)) {
      total = vaddq_u16(total, vld1q_u16(path + i));
    }
    vst1q_u16(sums.data() + i, total);
  }
}

}  // namespace

template <typename Types>
void sum_path_costs(std::span<const typename Types::Cost* const> paths,
                    std::span<typename Types::Sum> sums) noexcept {
  add_up(paths, sums);
}

STOF_INSTANTIATE(SumPathCosts, sum_path_costs, BytesToBytes, BytesToWords, WordsToWords);

}  // namespace stof::dsp::neon
