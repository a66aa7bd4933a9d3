#include "lab/cost/cost_sums.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/lanes_neon.h"
#include "lab/cost/slide_rows_neon.h"

namespace stof::dsp::neon {
namespace {

// Four vectors of candidates at a time keep their running sums in registers over the whole row.
template <typename Sum, std::size_t kVectors>
void sum_strip(const Sum* columns, std::size_t block_width, std::size_t lanes, Sum* costs,
               std::size_t outputs) noexcept {
  using L = Lanes<Sum>;
  constexpr std::size_t kStep = L::kLanes;
  typename L::V sums[kVectors];
  for (std::size_t v = 0; v < kVectors; ++v) {
    sums[v] = L::all(0);
    for (std::size_t k = 0; k < block_width; ++k) {
      sums[v] = sums[v] + L::load(columns + k * lanes + v * kStep);
    }
    L::store(costs + v * kStep, sums[v]);
  }
  for (std::size_t x = 1; x < outputs; ++x) {
    const Sum* const leaving = columns + (x - 1) * lanes;
    const Sum* const entering = leaving + block_width * lanes;
    for (std::size_t v = 0; v < kVectors; ++v) {
      sums[v] = sums[v] + (L::load(entering + v * kStep) - L::load(leaving + v * kStep));
      L::store(costs + x * lanes + v * kStep, sums[v]);
    }
  }
}

}  // namespace

template <typename Sum>
void slide_differences(std::span<const std::uint8_t> new_left,
                       std::span<const std::uint8_t> new_right,
                       std::span<const std::uint8_t> old_left,
                       std::span<const std::uint8_t> old_right, int lanes,
                       std::span<Sum> columns) noexcept {
  slide_rows(new_left, new_right, old_left, old_right, lanes, columns,
             Lanes<std::uint8_t>::difference);
}

template <typename Sum>
void block_sums(std::span<const Sum> columns, int block_width, int lanes,
                std::span<Sum> costs) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  const std::size_t block = static_cast<std::size_t>(block_width);
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && block_width >= 1);
  STOF_CHECK(columns.size() == costs.size() + (block - 1) * count);
  const std::size_t outputs = costs.size() / count;
  if (outputs == 0) {
    return;
  }
  constexpr std::size_t kWide = 4 * Lanes<Sum>::kLanes;
  std::size_t i = 0;
  for (; i + kWide <= count; i += kWide) {
    sum_strip<Sum, 4>(columns.data() + i, block, count, costs.data() + i, outputs);
  }
  for (; i < count; i += Lanes<Sum>::kLanes) {
    sum_strip<Sum, 1>(columns.data() + i, block, count, costs.data() + i, outputs);
  }
}

template <typename Sum>
void add_costs(std::span<const std::uint8_t> costs, std::span<Sum> columns) noexcept {
  STOF_CHECK(costs.size() == columns.size() && costs.size() % kCostLanes == 0);
  for (std::size_t j = 0; j < columns.size(); j += kCostLanes) {
    accumulate(vld1q_u8(costs.data() + j), columns.data() + j);
  }
}

template <typename Sum>
void slide_costs(std::span<const std::uint8_t> entering, std::span<const std::uint8_t> leaving,
                 std::span<Sum> columns) noexcept {
  STOF_CHECK(entering.size() == columns.size() && leaving.size() == columns.size() &&
             columns.size() % kCostLanes == 0);
  for (std::size_t j = 0; j < columns.size(); j += kCostLanes) {
    exchange(vld1q_u8(entering.data() + j), vld1q_u8(leaving.data() + j), columns.data() + j);
  }
}

STOF_INSTANTIATE(SlideDifferences, slide_differences, std::uint16_t, std::uint32_t);
STOF_INSTANTIATE(BlockSums, block_sums, std::uint16_t, std::uint32_t);
STOF_INSTANTIATE(AddCosts, add_costs, std::uint16_t, std::uint32_t);
STOF_INSTANTIATE(SlideCosts, slide_costs, std::uint16_t, std::uint32_t);

}  // namespace stof::dsp::neon
