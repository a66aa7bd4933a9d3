#include <type_traits>

#include "dsp/base/check.h"
#include "dsp/stereo/row_search.h"
#include "dsp/stereo/search/energy.h"
#include "dsp/stereo/search/ordered.h"

// What a RowSearch takes.
namespace stof::dsp {
namespace {

std::size_t size(int value) noexcept { return static_cast<std::size_t>(value); }

bool is_method(const MatchParams& params, Method method) noexcept {
  return params.method == method;
}

using NarrowPaths = SemiGlobal<std::uint8_t, std::uint8_t>;
using MixedPaths = SemiGlobal<std::uint8_t, std::uint16_t>;
using BlockPaths = SemiGlobal<std::uint16_t, std::uint16_t>;

std::size_t path_bytes(const MatchParams& params, int width) noexcept {
  if (params.cost != Cost::kMixed) {
    return BlockPaths::bytes_needed(block_path_params(params), width);
  }
  const PathParams<std::uint8_t> how = mixed_path_params(params);
  return fit_narrow_sums(how) ? NarrowPaths::bytes_needed(how, width)
                              : MixedPaths::bytes_needed(how, width);
}

// What block matching itself keeps nothing for.
bool looks_at_costs(const MatchParams& params) noexcept {
  return params.distinct || params.confidence || params.uniqueness_percent ||
         params.left_right_tolerance || params.guided;
}

template <typename Sum>
bool searches_blocks(const MatchParams& params) noexcept {
  return std::is_same_v<Sum, std::uint16_t> && BlockSearch::serves(params);
}

// Costs with room for what the fits read around them.
template <typename Sum>
std::size_t cost_count(const MatchParams& params, int width) noexcept {
  const bool needless = searches_blocks<Sum>(params) && !looks_at_costs(params);
  return needless ? 0 : size(width) * size(lanes_of(params)) + 2 * kBlockCostMargin;
}

}  // namespace

template <typename Sum>
std::size_t RowSearch<Sum>::bytes_needed(const MatchParams& params, int width) noexcept {
  const std::size_t lanes = size(lanes_of(params));
  const std::size_t row = Arena::bytes_for<Sum>(size(width) * lanes);
  std::size_t bytes = Arena::bytes_for<Sum>(cost_count<Sum>(params, width)) +
                      Arena::bytes_for<Sum>(size(width) + 1) +
                      4 * Arena::bytes_for<std::uint8_t>(size(width)) +
                      Arena::bytes_for<std::int16_t>(size(width));
  if (params.cost == Cost::kMixed) {
    bytes += CrossCosts::bytes_needed(params, width) +
             Arena::bytes_for<std::uint8_t>(size(width) * lanes);
  } else if (searches_blocks<Sum>(params)) {
    bytes += BlockSearch::bytes_needed(params, width) + Arena::bytes_for<Disparity>(size(width));
  } else {
    bytes += CostRows::bytes_needed(params, width);
  }
  if (is_method(params, Method::kScanline)) {
    bytes += 2 * row;
  }
  if (is_method(params, Method::kOrdered)) {
    bytes += Arena::bytes_for<std::byte>(ordered_bytes_needed<Sum>(width, lanes_of(params)));
  }
  if (is_method(params, Method::kSemiGlobal)) {
    bytes += path_bytes(params, width);
  } else {
    bytes += params.guided ? row : 0;
  }
  return bytes;
}

template <typename Sum>
RowSearch<Sum>::RowSearch(const MatchParams& params, int width, Arena& arena) noexcept
    : params_(params), lanes_(lanes_of(params)) {
  const std::size_t row = size(width) * size(lanes_);
  if (!is_method(params, Method::kSemiGlobal)) {
    penalties_ = block_penalties<Sum>(params);
    occlusion_ = block_occlusion<Sum>(params);
  }
  costs_ = arena.take<Sum>(cost_count<Sum>(params, width));
  costs_ = costs_.empty() ? costs_ : costs_.subspan(kBlockCostMargin, row);
  large_ = arena.take<Sum>(size(width) + 1);
  continued_ = arena.take<std::uint8_t>(size(width));
  interesting_left_ = arena.take<std::uint8_t>(size(width));
  interesting_right_ = arena.take<std::uint8_t>(size(width));
  winners_ = arena.take<std::int16_t>(size(width));
  if (params.cost == Cost::kMixed) {
    cross_rows_.emplace(params, width, arena);
    narrow_ = arena.take<std::uint8_t>(row);
  } else if (searches_blocks<Sum>(params)) {
    block_search_.emplace(params, width, arena);
    fitted_ = arena.take<Disparity>(size(width));
  } else {
    block_rows_.emplace(params, width, arena);
  }
  if (is_method(params, Method::kScanline)) {
    paths_ = arena.take<Sum>(row);
    marginals_ = arena.take<Sum>(row);
  }
  if (is_method(params, Method::kOrdered)) {
    ordered_scratch_ = arena.take<std::byte>(ordered_bytes_needed<Sum>(width, lanes_));
  }
  if (is_method(params, Method::kSemiGlobal)) {
    const PathParams<std::uint8_t> mixed = mixed_path_params(params);
    if (params.cost != Cost::kMixed) {
      block_paths_.emplace(block_path_params(params), width, arena);
    } else if (fit_narrow_sums(mixed)) {
      narrow_paths_.emplace(mixed, width, arena);
    } else {
      mixed_paths_.emplace(mixed, width, arena);
    }
  } else if (params.guided) {
    masked_ = arena.take<Sum>(row);
  }
}

template std::size_t RowSearch<std::uint16_t>::bytes_needed(const MatchParams&, int) noexcept;
template std::size_t RowSearch<std::uint32_t>::bytes_needed(const MatchParams&, int) noexcept;
template RowSearch<std::uint16_t>::RowSearch(const MatchParams&, int, Arena&) noexcept;
template RowSearch<std::uint32_t>::RowSearch(const MatchParams&, int, Arena&) noexcept;

}  // namespace stof::dsp
