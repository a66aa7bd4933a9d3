#include "dsp/stereo/search/block_winners.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"

namespace stof::dsp::ref {
namespace {

std::size_t size(int value) noexcept { return static_cast<std::size_t>(value); }

int difference(int a, int b) noexcept { return a < b ? b - a : a - b; }

// Costs of column x of the row, kNoCost where there is no candidate.
std::uint16_t cost_at(const BlockRow& row, std::span<const std::uint16_t> columns, std::size_t x,
                      int candidate) noexcept {
  const int right = row.x + static_cast<int>(x) - row.min_disparity - candidate;
  if (candidate >= row.disparities || right < 0 || right >= row.right_width) {
    return kNoCost<std::uint16_t>;
  }
  int sum = 0;
  for (std::size_t k = x; k < x + size(row.block_width); ++k) {
    sum += columns[k * size(row.lanes) + size(candidate)] / kBlockSumScale;
  }
  return static_cast<std::uint16_t>(sum);
}

void fit(const BlockRow& row, std::span<const std::uint16_t> costs, std::int16_t winner,
         Disparity& out) noexcept {
  const std::span<const std::int16_t> winners{&winner, 1};
  const std::span<Disparity> fitted{&out, 1};
  switch (row.fit) {
    case CostFit::kNone:
      whole_winners(row.min_disparity, winners, fitted);
      break;
    case CostFit::kEquiangular:
      refine_winners(costs, row.lanes, row.min_disparity, winners, fitted);
      break;
    case CostFit::kParabola:
      refine_winners_parabola(costs, row.lanes, row.min_disparity, winners, fitted);
      break;
  }
}

}  // namespace

void block_winners(const BlockPixels& pixels, const BlockRow& row, std::span<std::uint16_t> columns,
                   const BlockMatches& out) noexcept {
  const std::size_t n = pixels.new_left.size();
  const std::size_t lanes = size(row.lanes);
  STOF_CHECK(columns.size() == n * lanes && lanes <= 256 &&
             out.winners.size() + size(row.block_width) == n + 1);
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t i = 0; i < lanes; ++i) {
      const std::size_t right = n - 1 - k + i;
      const int change = difference(pixels.new_left[k], pixels.new_right[right]) -
                         difference(pixels.old_left[k], pixels.old_right[right]);
      std::uint16_t& sum = columns[k * lanes + i];
      sum = static_cast<std::uint16_t>(sum + kBlockSumScale * change);
    }
  }
  for (std::size_t x = 0; x < out.winners.size(); ++x) {
    std::uint16_t costs[256];
    for (int i = 0; i < row.lanes; ++i) {
      costs[i] = cost_at(row, columns, x, i);
    }
    const std::span<const std::uint16_t> pixel = std::span(costs).first(lanes);
    winners(pixel, row.lanes, out.winners.subspan(x, 1));
    fit(row, pixel, out.winners[x], out.fitted[x]);
    if (!out.costs.empty()) {
      std::ranges::copy(pixel, out.costs.subspan(x * lanes).begin());
    }
  }
}

}  // namespace stof::dsp::ref
