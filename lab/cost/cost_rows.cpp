#include "lab/cost/cost_rows.h"

#include <algorithm>
#include <type_traits>

#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "dsp/base/target.h"
#include "dsp/stereo/cost/census.h"
#include "dsp/stereo/cost/sad.h"
#include "lab/cost/cost_sums.h"
#include "lab/cost/ssd.h"
#include "lab/search/energy.h"

namespace stof::lab {
namespace {

// What PixelCosts computes.
std::optional<PixelCost> pixel_cost(Cost cost) noexcept {
  switch (cost) {
    case Cost::kCensus5x5:
      return PixelCost::kCensus5x5;
    case Cost::kCensus9x7:
      return PixelCost::kCensus9x7;
    case Cost::kAdCensus:
      return PixelCost::kAdCensus;
    case Cost::kSad:
    case Cost::kSsd:
      break;
  }
  return std::nullopt;
}

}  // namespace

bool CostRows::wide(const MatchParams& params) noexcept {
  return !sums_fit_u16(params.block_width, params.block_height, largest_difference(params));
}

CostRows::CostRows(const MatchParams& params, int width, Arena& arena) noexcept
    : params_(params), width_(width), lanes_(lanes_of(params)), columns_(block_columns(params)) {
  STOF_CHECK(width >= 1 && params.disparities >= 1 && params.block_width >= 1 &&
             params.block_width <= kMaxBlock && params.block_height >= 1 &&
             params.block_height <= kMaxBlock);
  const std::size_t columns = index(width + params.block_width - 1) * index(lanes_);
  const std::size_t costs = index(width) * index(lanes_);
  if (wide(params)) {
    wide_sums_.columns = arena.take<std::uint32_t>(columns);
    wide_sums_.costs = arena.take<std::uint32_t>(costs);
  } else {
    narrow_sums_.columns = arena.take<std::uint16_t>(columns);
    narrow_sums_.costs = arena.take<std::uint16_t>(costs);
  }
  if (const std::optional<PixelCost> cost = pixel_cost(params.cost)) {
    pixels_.emplace(*cost, params, width, columns_, arena);
    kept_ = arena.take<std::uint8_t>(index(params.block_height + 1) * columns);
    return;
  }
  new_ = RowPair::take(params, width, arena);
  old_ = RowPair::take(params, width, arena);
}

void CostRows::start(const CostPictures& pictures) noexcept {
  STOF_CHECK(same_size(pictures.left, pictures.right) && pictures.left.width() <= width_);
  pictures_ = pictures;
  y_.reset();
  if (pixels_) {
    pixels_->start(pictures);
  }
}

std::size_t CostRows::widened() const noexcept {
  return index(pictures_.left.width() + params_.block_width - 1);
}

template <typename Sum>
CostRows::Sums<Sum> CostRows::sums() const noexcept {
  STOF_CHECK(wide(params_) == (sizeof(Sum) == sizeof(std::uint32_t)));
  const std::size_t columns = widened() * index(lanes_);
  const std::size_t costs = index(pictures_.left.width()) * index(lanes_);
  if constexpr (std::is_same_v<Sum, std::uint32_t>) {
    return {wide_sums_.columns.first(columns), wide_sums_.costs.first(costs)};
  } else {
    return {narrow_sums_.columns.first(columns), narrow_sums_.costs.first(costs)};
  }
}

// Rows above and below the picture have places too: y is at least -kMaxBlock.
std::span<std::uint8_t> CostRows::kept(int y) const noexcept {
  const std::size_t row = widened() * index(lanes_);
  const int rows = params_.block_height + 1;
  return kept_.subspan(index((y + kMaxBlock * rows) % rows) * row, row);
}

template <typename Sum>
void CostRows::enter(int y, std::span<Sum> columns) noexcept {
  if (pixels_) {
    pixels_->row(std::clamp(y, 0, pictures_.left.height() - 1), kept(y));
    best::add_costs(kept(y), columns);
    return;
  }
  const RowPair rows = new_.load(pictures_, y, params_);
  if (params_.cost == Cost::kSad) {
    best::add_differences(rows.left, rows.right, lanes_, columns);
  } else {
    best::add_squares(rows.left, rows.right, lanes_, columns);
  }
}

template <typename Sum>
void CostRows::exchange(int entering, int leaving, std::span<Sum> columns) noexcept {
  if (pixels_) {
    pixels_->row(std::clamp(entering, 0, pictures_.left.height() - 1), kept(entering));
    best::slide_costs(kept(entering), kept(leaving), columns);
    return;
  }
  const RowPair in = new_.load(pictures_, entering, params_);
  const RowPair out = old_.load(pictures_, leaving, params_);
  if (params_.cost == Cost::kSad) {
    best::slide_differences(in.left, in.right, out.left, out.right, lanes_, columns);
  } else {
    best::slide_squares(in.left, in.right, out.left, out.right, lanes_, columns);
  }
}

template <typename Sum>
std::span<const Sum> CostRows::row(int y) noexcept {
  STOF_CHECK(y >= 0 && y < pictures_.left.height() && !pictures_.left.empty());
  const Sums<Sum> at = sums<Sum>();
  if (y_ == y) {
    return at.costs;
  }
  const int above = params_.block_height / 2;
  const int below = params_.block_height - 1 - above;
  if (y_ && *y_ + 1 == y) {
    exchange(y + below, y - 1 - above, at.columns);
  } else {
    std::ranges::fill(at.columns, Sum{0});
    for (int row = y - above; row <= y + below; ++row) {
      enter(row, at.columns);
    }
  }
  y_ = y;
  best::block_sums(std::span<const Sum>(at.columns), params_.block_width, lanes_, at.costs);
  mark_outside(params_, pictures_.left.width(), at.costs);
  return at.costs;
}

template std::span<const std::uint16_t> CostRows::row(int y) noexcept;
template std::span<const std::uint32_t> CostRows::row(int y) noexcept;

}  // namespace stof::lab
