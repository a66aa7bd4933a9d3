#include "lab/cost/cost_sums.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"
#include "dsp/stereo/cost/accumulate_neon.h"
#include "dsp/stereo/cost/sad.h"

namespace stof::dsp::neon {

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

STOF_INSTANTIATE(AddCosts, add_costs, std::uint16_t, std::uint32_t);
STOF_INSTANTIATE(SlideCosts, slide_costs, std::uint16_t, std::uint32_t);

}  // namespace stof::dsp::neon
