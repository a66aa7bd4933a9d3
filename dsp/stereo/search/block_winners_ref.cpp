#include "dsp/stereo/search/block_winners.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/index.h"

namespace stof::dsp::ref {
namespace {

int difference(int a, int b) noexcept { return a < b ? b - a : a - b; }

// Costs of column x of the row, kNoCost where there is no candidate.
std::uint16_t cost_at(const BlockRow& row, std::span<const std::uint16_t> columns, std::size_t x,
                      int candidate) noexcept {
  const int right = row.x + static_cast<int>(x) - row.min_disparity - candidate;
  if (candidate >= row.disparities || right < 0 || right >= row.right_width) {
    return kNoCost<std::uint16_t>;
  }
  int sum = 0;
  for (std::size_t k = x; k < x + index(row.block_width); ++k) {
    sum += columns[k * index(row.lanes) + index(candidate)] / kBlockSumScale;
  }
  return static_cast<std::uint16_t>(sum);
}

}  // namespace

void block_winners(const BlockPixels& pixels, const BlockRow& row, std::span<std::uint16_t> columns,
                   const BlockMatches& out) noexcept {
  const std::size_t n = pixels.new_left.size();
  const std::size_t lanes = index(row.lanes);
  STOF_CHECK(columns.size() == n * lanes && lanes <= 256 &&
             out.winners.size() + index(row.block_width) == n + 1);
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
    refine_winners(pixel, row.lanes, row.fit, row.min_disparity,
                   std::span<const std::int16_t>(out.winners.subspan(x, 1)),
                   out.fitted.subspan(x, 1));
    if (!out.costs.empty()) {
      const std::span<std::uint16_t> kept = out.costs.subspan(x * lanes, lanes);
      for (std::size_t i = 0; i < lanes; ++i) {
        kept[i] = out.numbered ? numbered_cost(pixel[i], static_cast<int>(i)) : pixel[i];
      }
    }
    if (!out.margins.empty()) {
      winner_margins(pixel, row.lanes, std::span<const std::int16_t>(out.winners.subspan(x, 1)),
                     row.margin.percent, row.margin.shift, out.margins.subspan(x, 1));
    }
  }
}

}  // namespace stof::dsp::ref
