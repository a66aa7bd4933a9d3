#include "dsp/stereo/cost/cost_layout.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/image.h"
#include "dsp/base/index.h"
#include "dsp/stereo/cost/sad.h"

namespace stof::dsp {

int lanes_of(const MatchParams& params) noexcept {
  return (params.disparities + kCostLanes - 1) / kCostLanes * kCostLanes;
}

CostColumns block_columns(const MatchParams& params) noexcept {
  const int before = params.block_width / 2;
  return {before, params.block_width - 1 - before};
}

void extend_row(std::span<const std::uint8_t> row, CostColumns columns,
                std::span<std::uint8_t> out) noexcept {
  STOF_CHECK(!row.empty() && out.size() == row.size() + index(columns.before + columns.after));
  std::ranges::fill(out.first(index(columns.before)), row.front());
  std::ranges::copy(row, out.subspan(index(columns.before)).begin());
  std::ranges::fill(out.last(index(columns.after)), row.back());
}

void reverse_row(std::span<const std::uint8_t> row, CostColumns columns, int min_disparity,
                 std::span<std::uint8_t> out) noexcept {
  const int width = static_cast<int>(row.size());
  const int count = static_cast<int>(out.size());
  STOF_CHECK(width > 0 && count >= width + columns.before + columns.after);
  // Element m stands for x = first - m: the border, the row from right to left, the other border.
  const int first = width + columns.after - 1 - min_disparity;
  const int begin = std::clamp(first - (width - 1), 0, count);
  const int end = std::clamp(first + 1, begin, count);
  std::ranges::fill(out.first(index(begin)), row.back());
  if (begin < end) {
    std::reverse_copy(row.begin() + (first - (end - 1)), row.begin() + (first - begin + 1),
                      out.begin() + begin);
  }
  std::ranges::fill(out.subspan(index(end)), row.front());
}

RowPair RowPair::take(const MatchParams& params, int width, Arena& arena) noexcept {
  const int left = width + params.block_width - 1;
  return {.left = arena.take_passing<std::uint8_t>(index(left)),
          .right = arena.take_passing<std::uint8_t>(index(left + lanes_of(params) - 1))};
}

RowPair RowPair::load(const CostPictures& pictures, int y,
                      const MatchParams& params) const noexcept {
  const CostColumns columns = block_columns(params);
  const int n = pictures.left.width() + params.block_width - 1;
  const RowPair rows{left.first(index(n)), right.first(index(n + lanes_of(params) - 1))};
  extend_row(pictures.left.row_clamped(y), columns, rows.left);
  reverse_row(pictures.right.row_clamped(y), columns, params.min_disparity, rows.right);
  return rows;
}

template <typename Sum>
void mark_outside(const MatchParams& params, int width, std::span<Sum> costs) noexcept {
  const int lanes = lanes_of(params);
  STOF_CHECK(costs.size() == index(width) * index(lanes));
  const auto mark = [&](Rows columns) noexcept {
    for (int x = columns.begin; x < columns.end; ++x) {
      const int farthest = x - params.min_disparity;  // the candidate that meets right column 0
      const int begin = std::clamp(farthest - width + 1, 0, lanes);
      const int end = std::clamp(std::min(params.disparities, farthest + 1), begin, lanes);
      const std::span<Sum> pixel = costs.subspan(index(x) * index(lanes), index(lanes));
      std::ranges::fill(pixel.first(index(begin)), kNoCost<Sum>);
      std::ranges::fill(pixel.subspan(index(end)), kNoCost<Sum>);
    }
  };
  // Nearly every pixel has all candidates.
  const int whole_end = std::clamp(width + params.min_disparity, 0, width);
  const int whole = params.disparities < lanes
                        ? whole_end
                        : std::clamp(lanes - 1 + params.min_disparity, 0, whole_end);
  mark({0, whole});
  mark({whole_end, width});
}

template void mark_outside(const MatchParams&, int, std::span<std::uint8_t>) noexcept;
template void mark_outside(const MatchParams&, int, std::span<std::uint16_t>) noexcept;
template void mark_outside(const MatchParams&, int, std::span<std::uint32_t>) noexcept;

}  // namespace stof::dsp
