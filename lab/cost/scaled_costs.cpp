#include "lab/cost/scaled_costs.h"

#include <algorithm>

#include "lab/search/energy.h"

namespace stof::lab {
namespace {

template <typename Sum>
void scale(std::span<const Sum> sums, std::uint32_t factor,
           std::span<std::uint16_t> costs) noexcept {
  std::ranges::transform(sums, costs.begin(), [&](Sum sum) noexcept {
    const std::uint64_t scaled = (std::uint64_t{sum} * factor + 32768) >> 16;
    return sum == kNoCost<Sum> ? kNoCost<std::uint16_t> : static_cast<std::uint16_t>(scaled);
  });
}

}  // namespace

void ScaledCosts::start(CostRows& rows, const MatchParams& params) noexcept {
  rows_ = &rows;
  wide_ = CostRows::wide(params);
  factor_ = path_factor(params);
}

void ScaledCosts::row(int y, std::span<std::uint16_t> costs) noexcept {
  if (wide_) {
    scale(rows_->row<std::uint32_t>(y), factor_, costs);
  } else {
    scale(rows_->row<std::uint16_t>(y), factor_, costs);
  }
}

}  // namespace stof::lab
