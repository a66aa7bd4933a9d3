#include "dsp/stereo/cost/pixel_costs.h"

#include <array>

#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "dsp/base/target.h"
#include "dsp/stereo/cost/ad_census.h"
#include "dsp/stereo/cost/census.h"
#include "dsp/stereo/cost/hamming.h"
#include "dsp/stereo/prefilter/prefilter.h"

namespace stof::dsp {
namespace {

// Steeper slopes are all edges alike.
constexpr int kDerivativeCap = 20;

int bits_of(PixelCost cost) noexcept {
  switch (cost) {
    case PixelCost::kCensus5x5:
      return kCensus5x5.bits();
    case PixelCost::kCensus9x7:
      return kCensus9x7.bits();
    case PixelCost::kAdCensus:
      break;
  }
  return kCensus7x7.bits();
}

// Elements of a left row; a right row has lanes - 1 more.
std::size_t elements(int width, CostColumns columns) noexcept {
  return index(width + columns.before + columns.after);
}

template <std::size_t kRows>
std::array<std::span<const std::uint8_t>, kRows> window(ImageView<const std::uint8_t> picture,
                                                        int y) noexcept {
  std::array<std::span<const std::uint8_t>, kRows> rows;
  int at = y - static_cast<int>(kRows / 2);
  for (std::span<const std::uint8_t>& row : rows) {
    row = picture.row_clamped(at);
    ++at;
  }
  return rows;
}

}  // namespace

PixelCosts::PixelCosts(PixelCost cost, const MatchParams& params, int width, CostColumns columns,
                       Arena& arena) noexcept
    : cost_(cost),
      min_disparity_(params.min_disparity),
      columns_(columns),
      width_(width),
      lanes_(lanes_of(params)) {
  STOF_CHECK(width >= 1 && columns.before >= 0 && columns.after >= 0);
  const std::size_t planes = planes_of(bits_of(cost));
  const std::size_t left = elements(width, columns);
  const std::size_t right = left + index(lanes_) - 1;
  described_ = arena.take_passing<std::uint8_t>(planes * index(width));
  left_.planes = arena.take_passing<std::uint8_t>(planes * left);
  right_.planes = arena.take_passing<std::uint8_t>(planes * right);
  if (cost == PixelCost::kAdCensus) {
    derived_ = arena.take_passing<std::uint8_t>(index(width));
    left_.grey = arena.take_passing<std::uint8_t>(left);
    left_.derivative = arena.take_passing<std::uint8_t>(left);
    right_.grey = arena.take_passing<std::uint8_t>(right);
    right_.derivative = arena.take_passing<std::uint8_t>(right);
  }
}

void PixelCosts::start(const CostPictures& pictures) noexcept {
  STOF_CHECK(same_size(pictures.left, pictures.right) && pictures.left.width() <= width_);
  pictures_ = pictures;
}

void PixelCosts::describe(ImageView<const std::uint8_t> picture, int y) noexcept {
  const std::span<std::uint8_t> planes =
      described_.first(planes_of(bits_of(cost_)) * index(picture.width()));
  switch (cost_) {
    case PixelCost::kCensus5x5:
      best::census_5x5(window<5>(picture, y), planes);
      return;
    case PixelCost::kCensus9x7:
      best::census_9x7(window<7>(picture, y), planes);
      return;
    case PixelCost::kAdCensus:
      best::census_7x7(window<7>(picture, y), planes);
      best::clipped_sobel(picture.row_clamped(y - 1), picture.row(y), picture.row_clamped(y + 1),
                          kDerivativeCap, derived_.first(index(picture.width())));
      return;
  }
}

void PixelCosts::row(int y, std::span<std::uint8_t> costs) noexcept {
  const std::size_t width = index(pictures_.left.width());
  const std::size_t n = elements(pictures_.left.width(), columns_);
  const std::size_t candidates = n + index(lanes_) - 1;
  const int bits = bits_of(cost_);
  const std::size_t planes = planes_of(bits);
  STOF_CHECK(y >= 0 && y < pictures_.left.height() && costs.size() == n * index(lanes_));
  const auto extend = [&](std::span<const std::uint8_t> from, std::span<std::uint8_t> to) noexcept {
    extend_row(from, columns_, to);
  };
  const auto reverse = [&](std::span<const std::uint8_t> from,
                           std::span<std::uint8_t> to) noexcept {
    reverse_row(from, columns_, min_disparity_, to);
  };

  const bool mixed = cost_ == PixelCost::kAdCensus;
  describe(pictures_.left, y);
  for (std::size_t p = 0; p < planes; ++p) {
    extend(described_.subspan(p * width, width), left_.planes.subspan(p * n, n));
  }
  if (mixed) {
    extend(pictures_.left.row(y), left_.grey.first(n));
    extend(derived_.first(width), left_.derivative.first(n));
  }
  describe(pictures_.right, y);
  for (std::size_t p = 0; p < planes; ++p) {
    reverse(described_.subspan(p * width, width),
            right_.planes.subspan(p * candidates, candidates));
  }
  if (mixed) {
    reverse(pictures_.right.row(y), right_.grey.first(candidates));
    reverse(derived_.first(width), right_.derivative.first(candidates));
  }
  const std::span<const std::uint8_t> left = left_.planes.first(planes * n);
  const std::span<const std::uint8_t> right = right_.planes.first(planes * candidates);
  if (!mixed) {
    best::hamming_costs(left, right, bits, lanes_, costs);
    return;
  }
  best::ad_census_costs(
      {.planes = left, .grey = left_.grey.first(n), .derivative = left_.derivative.first(n)},
      {.planes = right,
       .grey = right_.grey.first(candidates),
       .derivative = right_.derivative.first(candidates)},
      lanes_, costs);
}

}  // namespace stof::dsp
