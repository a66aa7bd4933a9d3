#include "dsp/stereo/cost/aggregated_ad_census.h"

#include <algorithm>
#include <array>

#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "dsp/base/target.h"
#include "dsp/stereo/cost/cost_layout.h"

namespace stof::dsp {
namespace {

constexpr std::uint32_t kLargestArea = 9;

// kReciprocals[area], Q15.
constexpr auto kReciprocals = [] {
  std::array<std::int16_t, kLargestArea + 1> table{};
  for (std::uint32_t area = 1; area <= kLargestArea; ++area) {
    const std::uint32_t divisor = area * kMeanDivisor;
    table[area] = static_cast<std::int16_t>((32768 * kMeanScale + divisor / 2) / divisor);
  }
  return table;
}();

// joined[x] = 1 where a[x] and b[x] look alike. Written so that compilers see vectors.
void join(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b,
          std::span<std::uint8_t> joined) noexcept {
  for (std::size_t x = 0; x < a.size(); ++x) {
    const auto difference = static_cast<std::uint8_t>(std::max(a[x], b[x]) - std::min(a[x], b[x]));
    joined[x] = difference <= kAlike ? std::uint8_t{1} : std::uint8_t{0};
  }
}

// counts[x] = pixels of column x and of those beside it that look alike. Without a branch, too.
void count(std::span<const std::uint8_t> joined, std::span<std::uint8_t> counts) noexcept {
  for (std::size_t x = 0; x < counts.size(); ++x) {
    counts[x] = static_cast<std::uint8_t>(1 + joined[x] + joined[x + 1]);
  }
}

// areas[x] += counts[x] where with[x] is 1.
void add_counts(std::span<const std::uint8_t> counts, std::span<const std::uint8_t> with,
                std::span<std::uint8_t> areas) noexcept {
  for (std::size_t x = 0; x < areas.size(); ++x) {
    const auto mask = static_cast<std::uint8_t>(0 - with[x]);
    areas[x] = static_cast<std::uint8_t>(areas[x] + (counts[x] & mask));
  }
}

}  // namespace

AggregatedAdCensus::AggregatedAdCensus(const MatchParams& params, int width, Arena& arena) noexcept
    : params_(params),
      lanes_(index(lanes_of(params))),
      pixels_(PixelCost::kAdCensus, params, width, {}, arena) {
  const std::size_t n = index(width);
  sums_ = arena.take_passing<std::uint8_t>(index(kKept) * n * lanes_);
  counts_ = arena.take_passing<std::uint8_t>(index(kKept) * n);
  costs_ = arena.take_passing<std::uint8_t>(n * lanes_);
  joined_ = arena.take_passing<std::uint8_t>(n + 1);
  below_ = arena.take_passing<std::uint8_t>(n);
  areas_ = arena.take_passing<std::uint8_t>(n);
}

void AggregatedAdCensus::start(ImageView<const std::uint8_t> left,
                               ImageView<const std::uint8_t> right) noexcept {
  STOF_CHECK(same_size(left, right) && index(left.width()) <= areas_.size());
  left_ = left;
  pixels_.start({.left = left, .right = right});
  kept_ = {};
}

std::span<std::uint8_t> AggregatedAdCensus::sums(int y) const noexcept {
  const std::size_t n = width() * lanes_;
  return sums_.subspan(index(y % kKept) * n, n);
}

std::span<std::uint8_t> AggregatedAdCensus::counts(int y) const noexcept {
  return counts_.subspan(index(y % kKept) * width(), width());
}

void AggregatedAdCensus::row(int y, std::span<std::uint8_t> costs) noexcept {
  STOF_CHECK(y >= 0 && y < left_.height() && costs.size() == width() * lanes_);
  const int first = std::max(y - 1, 0);
  const int last = std::min(y + 1, left_.height() - 1);
  if (first < kept_.begin || first > kept_.end) {
    kept_ = {first, first};
  }
  for (; kept_.end <= last; ++kept_.end) {
    add_row(kept_.end);
  }
  kept_.begin = std::max(kept_.begin, kept_.end - kKept);

  const std::span<std::uint8_t> above = joined_.first(width());
  const std::span<std::uint8_t> below = below_.first(width());
  const auto join_rows = [&](int other, std::span<std::uint8_t> joined) noexcept {
    if (other == y) {  // beyond the border
      std::ranges::fill(joined, std::uint8_t{0});
    } else {
      join(left_.row(y), left_.row(other), joined);
    }
  };
  join_rows(first, above);
  join_rows(last, below);
  const std::span<std::uint8_t> areas = areas_.first(width());
  std::ranges::copy(counts(y), areas.begin());
  add_counts(counts(first), above, areas);
  add_counts(counts(last), below, areas);
  best::cross_means({.above = sums(first),
                     .here = sums(y),
                     .below = sums(last),
                     .with_above = above,
                     .with_below = below,
                     .areas = areas,
                     .reciprocals = kReciprocals},
                    static_cast<int>(lanes_), costs);
  mark_outside(params_, left_.width(), costs);
}

// Row y enters the rings.
void AggregatedAdCensus::add_row(int y) noexcept {
  const std::span<std::uint8_t> joined = joined_.first(width() + 1);
  const std::span<std::uint8_t> costs = costs_.first(width() * lanes_);
  const std::span<const std::uint8_t> grey = left_.row(y);
  pixels_.row(y, costs);
  joined.front() = 0;
  join(grey.subspan(1), grey.first(width() - 1), joined.subspan(1, width() - 1));
  joined.back() = 0;
  best::sum_alike(costs, joined, static_cast<int>(lanes_), sums(y));
  count(joined, counts(y));
}

}  // namespace stof::dsp
