#include "dsp/stereo/cost/sad.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"
#include "dsp/stereo/cost/accumulate_neon.h"
#include "dsp/stereo/cost/sums_neon.h"

namespace stof::dsp::neon {
namespace {

void check_sizes(std::size_t n, std::size_t right, int lanes, std::size_t columns) noexcept {
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0);
  STOF_CHECK(right == n + static_cast<std::size_t>(lanes) - 1);
  STOF_CHECK(columns == n * static_cast<std::size_t>(lanes));
}

template <typename Sum>
void add_rows(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right, int lanes,
              std::span<Sum> columns) noexcept {
  const std::size_t n = left.size();
  check_sizes(n, right.size(), lanes, columns.size());
  for (std::size_t k = 0; k < n; ++k) {
    const uint8x16_t pixel = vdupq_n_u8(left[k]);
    const std::uint8_t* const candidates = right.data() + (n - 1 - k);
    Sum* const sums = columns.data() + k * static_cast<std::size_t>(lanes);
    for (int i = 0; i < lanes; i += kCostLanes) {
      accumulate(vabdq_u8(pixel, vld1q_u8(candidates + i)), sums + i);
    }
  }
}

template <typename Sum>
void slide_rows(std::span<const std::uint8_t> new_left, std::span<const std::uint8_t> new_right,
                std::span<const std::uint8_t> old_left, std::span<const std::uint8_t> old_right,
                int lanes, std::span<Sum> columns) noexcept {
  const std::size_t n = new_left.size();
  check_sizes(n, new_right.size(), lanes, columns.size());
  STOF_CHECK(old_left.size() == n && old_right.size() == new_right.size());
  for (std::size_t k = 0; k < n; ++k) {
    const uint8x16_t entering = vdupq_n_u8(new_left[k]);
    const uint8x16_t leaving = vdupq_n_u8(old_left[k]);
    const std::size_t first = n - 1 - k;
    Sum* const sums = columns.data() + k * static_cast<std::size_t>(lanes);
    for (int i = 0; i < lanes; i += kCostLanes) {
      exchange(vabdq_u8(entering, vld1q_u8(new_right.data() + first + i)),
               vabdq_u8(leaving, vld1q_u8(old_right.data() + first + i)), sums + i);
    }
  }
}

// Four vectors of candidates at a time keep their running sums in registers over the whole row.
template <typename Sum, std::size_t kVectors>
void sum_strip(const Sum* columns, std::size_t block_width, std::size_t lanes, Sum* costs,
               std::size_t outputs) noexcept {
  constexpr std::size_t kStep = Vector<Sum>::kLanes;
  typename Vector<Sum>::type sums[kVectors];
  for (std::size_t v = 0; v < kVectors; ++v) {
    sums[v] = all(Sum{0});
    for (std::size_t k = 0; k < block_width; ++k) {
      sums[v] = add(sums[v], load(columns + k * lanes + v * kStep));
    }
    store(costs + v * kStep, sums[v]);
  }
  for (std::size_t x = 1; x < outputs; ++x) {
    const Sum* const leaving = columns + (x - 1) * lanes;
    const Sum* const entering = leaving + block_width * lanes;
    for (std::size_t v = 0; v < kVectors; ++v) {
      sums[v] = add(sums[v], sub(load(entering + v * kStep), load(leaving + v * kStep)));
      store(costs + x * lanes + v * kStep, sums[v]);
    }
  }
}

template <typename Sum>
void sum_blocks(std::span<const Sum> columns, int block_width, int lanes,
                std::span<Sum> costs) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  const std::size_t block = static_cast<std::size_t>(block_width);
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && block_width >= 1);
  STOF_CHECK(columns.size() == costs.size() + (block - 1) * count);
  const std::size_t outputs = costs.size() / count;
  if (outputs == 0) {
    return;
  }
  constexpr std::size_t kWide = 4 * Vector<Sum>::kLanes;
  std::size_t i = 0;
  for (; i + kWide <= count; i += kWide) {
    sum_strip<Sum, 4>(columns.data() + i, block, count, costs.data() + i, outputs);
  }
  for (; i < count; i += Vector<Sum>::kLanes) {
    sum_strip<Sum, 1>(columns.data() + i, block, count, costs.data() + i, outputs);
  }
}

}  // namespace

void add_differences(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right,
                     int lanes, std::span<std::uint16_t> columns) noexcept {
  add_rows(left, right, lanes, columns);
}
void add_differences(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right,
                     int lanes, std::span<std::uint32_t> columns) noexcept {
  add_rows(left, right, lanes, columns);
}

void slide_differences(std::span<const std::uint8_t> new_left,
                       std::span<const std::uint8_t> new_right,
                       std::span<const std::uint8_t> old_left,
                       std::span<const std::uint8_t> old_right, int lanes,
                       std::span<std::uint16_t> columns) noexcept {
  slide_rows(new_left, new_right, old_left, old_right, lanes, columns);
}
void slide_differences(std::span<const std::uint8_t> new_left,
                       std::span<const std::uint8_t> new_right,
                       std::span<const std::uint8_t> old_left,
                       std::span<const std::uint8_t> old_right, int lanes,
                       std::span<std::uint32_t> columns) noexcept {
  slide_rows(new_left, new_right, old_left, old_right, lanes, columns);
}

void block_sums(std::span<const std::uint16_t> columns, int block_width, int lanes,
                std::span<std::uint16_t> costs) noexcept {
  sum_blocks(columns, block_width, lanes, costs);
}
void block_sums(std::span<const std::uint32_t> columns, int block_width, int lanes,
                std::span<std::uint32_t> costs) noexcept {
  sum_blocks(columns, block_width, lanes, costs);
}

}  // namespace stof::dsp::neon
