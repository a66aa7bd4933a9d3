#include "dsp/stereo/cost/cross_costs.h"

#include <algorithm>
#include <array>

#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "dsp/base/target.h"
#include "dsp/stereo/cost/cost_layout.h"

namespace stof::dsp {
namespace {

// kReciprocals[area], as cross_aggregation.h wants it.
constexpr int kLargestArea = (2 * kCrossArms.longest + 1) * (2 * kCrossArms.longest + 1);
constexpr auto kReciprocals = [] {
  std::array<std::int16_t, kLargestArea + 1> table{};
  for (std::uint32_t area = 1; area <= kLargestArea; ++area) {
    table[area] =
        static_cast<std::int16_t>(std::min<std::uint32_t>((65536 + area / 2) / area, 32767));
  }
  return table;
}();

}  // namespace

CrossCosts::CrossCosts(const MatchParams& params, int width, Arena& arena) noexcept
    : params_(params),
      lanes_(index(lanes_of(params))),
      pixels_(PixelCost::kAdCensus, params, width, {}, arena) {
  const std::size_t n = index(width);
  summed_ = arena.take<std::uint16_t>(index(kKept) * n * lanes_);
  areas_ = arena.take<std::uint16_t>(index(kKept) * n);
  sums_ = arena.take<std::uint16_t>((n + 1) * lanes_);
  costs_ = arena.take<std::uint8_t>(n * lanes_);
  before_ = arena.take<std::uint8_t>(n);
  behind_ = arena.take<std::uint8_t>(n);
  ends_ = arena.take<CrossEnds>(n);
}

void CrossCosts::start(ImageView<const std::uint8_t> left,
                       ImageView<const std::uint8_t> right) noexcept {
  STOF_CHECK(same_size(left, right) && index(left.width()) <= ends_.size());
  left_ = left;
  pixels_.start({.left = left, .right = right});
  kept_ = {};
}

// Rows of the ring; row -1 is one like any other.
std::span<std::uint16_t> CrossCosts::summed(int y) const noexcept {
  const std::size_t n = width() * lanes_;
  return summed_.subspan(index((y + 2 * kKept) % kKept) * n, n);
}

std::span<std::uint16_t> CrossCosts::areas(int y) const noexcept {
  return areas_.subspan(index((y + 2 * kKept) % kKept) * width(), width());
}

void CrossCosts::row(int y, std::span<std::uint8_t> costs) noexcept {
  STOF_CHECK(y >= 0 && y < left_.height() && costs.size() == width() * lanes_);
  const int first = std::max(y - kCrossArms.longest, 0);
  const int last = std::min(y + kCrossArms.longest, left_.height() - 1);
  if (first < kept_.begin || first > kept_.end || kept_.count() == 0) {
    kept_ = {first, first};
    std::ranges::fill(summed(first - 1), std::uint16_t{0});
    std::ranges::fill(areas(first - 1), std::uint16_t{0});
  }
  for (; kept_.end <= last; ++kept_.end) {
    add_row(kept_.end);
  }
  kept_.begin = std::max(kept_.begin, kept_.end - (kKept - 1));

  const std::span<std::uint8_t> up = before_.first(width());
  const std::span<std::uint8_t> down = behind_.first(width());
  vertical_arms(y, -1, up);
  vertical_arms(y, 1, down);
  const std::span<CrossEnds> ends = ends_.first(width());
  // Where the row y + k - kCrossArms.longest - 1 of either ring begins.
  std::array<const std::uint16_t*, kKept> sums;
  std::array<const std::uint16_t*, kKept> counts;
  for (int k = 0; k < kKept; ++k) {
    sums[index(k)] = summed(y + k - kCrossArms.longest - 1).data();
    counts[index(k)] = areas(y + k - kCrossArms.longest - 1).data();
  }
  constexpr std::size_t kHere = kCrossArms.longest + 1;
  for (std::size_t x = 0; x < ends.size(); ++x) {
    const std::size_t above = kHere - up[x] - 1;
    const std::size_t below = kHere + down[x];
    const auto area = static_cast<std::uint16_t>(counts[below][x] - counts[above][x]);
    ends[x] = {sums[above], sums[below], kReciprocals[area]};
  }
  const int lanes = static_cast<int>(lanes_);
  best::cross_means(ends, lanes, costs);
  mark_outside(params_, left_.width(), costs);
}

// Row y enters the ring.
void CrossCosts::add_row(int y) noexcept {
  const int lanes = static_cast<int>(lanes_);
  const std::span<std::uint16_t> sums = sums_.first((width() + 1) * lanes_);
  const std::span<std::uint8_t> to_left = before_.first(width());
  const std::span<std::uint8_t> to_right = behind_.first(width());
  const std::span<std::uint8_t> costs = costs_.first(width() * lanes_);
  pixels_.row(y, costs);
  best::sum_along(costs, lanes, sums);
  best::arms_along(left_.row(y), kCrossArms, to_left, to_right);
  best::sum_down(sums, to_left, to_right, lanes, summed(y - 1), summed(y));
  const std::span<const std::uint16_t> above = areas(y - 1);
  const std::span<std::uint16_t> below = areas(y);
  for (std::size_t x = 0; x < width(); ++x) {
    below[x] = static_cast<std::uint16_t>(above[x] + to_left[x] + to_right[x] + 1);
  }
}

// direction -1: upwards, 1: downwards.
void CrossCosts::vertical_arms(int y, int direction, std::span<std::uint8_t> arms) noexcept {
  std::array<const std::uint8_t*, kCrossArms.longest> others;
  const int room = direction < 0 ? y : left_.height() - 1 - y;
  const int count = std::min(room, kCrossArms.longest);
  for (int k = 0; k < count; ++k) {
    others[index(k)] = left_.row(y + direction * (k + 1)).data();
  }
  best::arms_across(left_.row(y), std::span(others).first(index(count)), kCrossArms, arms);
}

}  // namespace stof::dsp
