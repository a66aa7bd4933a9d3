#include "lab/search/dynamic_programming.h"

#include <algorithm>

#include "dsp/base/check.h"
#include "dsp/stereo/search/winner.h"
#include "lab/search/scanline_optimisation.h"

namespace stof::lab {
namespace {

template <typename Sum>
Sum plus(Sum a, Sum b) noexcept {
  const Sum sum = static_cast<Sum>(a + b);
  return sum < a ? kNoCost<Sum> : sum;
}

// What is not reachable stays so.
template <typename Sum>
Sum minus(Sum a, Sum base) noexcept {
  return a == kNoCost<Sum> ? a : static_cast<Sum>(a - base);
}

template <typename Sum>
Sum lowest_of(const Sum* values, std::size_t count) noexcept {
  Sum lowest = kNoCost<Sum>;
  for (std::size_t i = 0; i < count; ++i) {
    lowest = std::min(lowest, values[i]);
  }
  return lowest;
}

// out[i] = the lower of values[i] and values[i + step]. No overlap: vectors of any length do it.
template <typename Sum>
void lower_pairs(const Sum* values, std::size_t count, std::size_t step, Sum* out) noexcept {
  const std::size_t pairs = step < count ? count - step : 0;
  for (std::size_t i = 0; i < pairs; ++i) {
    out[i] = std::min(values[i], values[i + step]);
  }
  std::copy(values + pairs, values + count, out + pairs);
}

// out[i] = the lowest of values[i + 1] and all above it, by doubling the reach. No overlap.
template <typename Sum>
void lowest_above(const Sum* values, std::size_t count, Sum* other, Sum* out) noexcept {
  std::copy(values + 1, values + count, out);
  out[count - 1] = kNoCost<Sum>;
  for (std::size_t step = 1; step < count; step *= 4) {
    lower_pairs(out, count, step, other);
    lower_pairs(other, count, 2 * step, out);
  }
}

// matched[x][i] before the cost of x itself, into out. x >= 1.
template <typename Sum>
void enter(const DpTable<Sum>& t, std::size_t x, const DpPenalties<Sum>& p, Sum* out) noexcept {
  const Sum* const before = t.matched_at(x - 1);
  const Sum* const hidden = t.hidden_at(x - 1);
  const Sum large = p.large[x];
  const Sum started = t.started[x];
  lowest_above(before, t.lanes, t.scratch.data() + t.lanes, out);
  for (std::size_t i = 0; i < t.lanes; ++i) {
    const Sum changed = plus(std::min(out[i], hidden[i]), large);
    out[i] = std::min(std::min(before[i], started), changed);
  }
  for (std::size_t i = 0; i + 1 < t.lanes; ++i) {
    out[i] = std::min(out[i], plus(before[i + 1], p.small));
  }
  if (x >= 2) {  // one left pixel without a match
    const Sum* const earlier = t.matched_at(x - 2);
    const Sum rise = t.base[x - 1];
    const Sum gap = plus(p.small, p.occlusion);
    for (std::size_t i = 1; i < t.lanes; ++i) {
      const Sum skipped = plus(earlier[i - 1], gap);
      out[i] = std::min(out[i], minus(skipped, rise));
    }
  }
}

// Fills column x of the table. ended: the energy when the last match lies before x; returned
// relative to x.
template <typename Sum>
Sum advance(DpTable<Sum>& t, std::size_t x, std::span<const Sum> costs, const DpPenalties<Sum>& p,
            Sum ended) noexcept {
  Sum* const matched = t.matched_at(x);
  Sum* const hidden = t.hidden_at(x);
  std::ranges::fill_n(hidden, static_cast<std::ptrdiff_t>(t.lanes), kNoCost<Sum>);
  if (x == 0) {
    std::ranges::copy(costs, matched);
  } else {
    enter(t, x, p, t.scratch.data());
    const Sum* const before = t.matched_at(x - 1);
    const Sum* const run = t.hidden_at(x - 1);
    for (std::size_t i = 0; i < t.lanes; ++i) {
      matched[i] = plus(costs[i], t.scratch[i]);
    }
    for (std::size_t i = 1; i < t.lanes; ++i) {
      hidden[i] = plus(std::min(before[i - 1], run[i - 1]), p.occlusion);
    }
  }
  const Sum start = plus(t.started[x], p.occlusion);
  const Sum base =
      std::min({lowest_of(matched, t.lanes), lowest_of(hidden, t.lanes), start, ended});
  for (std::size_t i = 0; i < t.lanes; ++i) {
    matched[i] = minus(matched[i], base);
    hidden[i] = minus(hidden[i], base);
  }
  t.base[x] = base;
  if (x + 1 < t.started.size()) {
    t.started[x + 1] = minus(start, base);
  }
  return minus(ended, base);
}

// The candidate of the last matched pixel before x, and how many pixels lie between.
struct Previous {
  int candidate = kNoWinner;  // none: x is the first one
  std::size_t skipped = 0;
};

template <typename Sum>
int position(const Sum* values, int begin, int end, Sum value) noexcept {
  return static_cast<int>(std::find(values + begin, values + end, value) - values);
}

// The match that opened the run of left pixels which ends before x, where i may follow.
template <typename Sum>
Previous opening(const DpTable<Sum>& t, std::size_t x, int i) noexcept {
  Previous match{i, 0};
  do {
    --match.candidate;
    ++match.skipped;
    x -= 1;
  } while (t.matched_at(x - 1)[match.candidate] > t.hidden_at(x - 1)[match.candidate]);
  return match;
}

// How matched[x][i] was entered: the argument of enter()'s minimum. x >= 1. Of equal ways the first
// in this order.
template <typename Sum>
Previous previous(const DpTable<Sum>& t, std::size_t x, int i, const DpPenalties<Sum>& p) noexcept {
  const std::size_t at = static_cast<std::size_t>(i);
  const Sum* const before = t.matched_at(x - 1);
  const Sum above = lowest_of(before + at + 1, t.lanes - at - 1);
  const Sum fall = plus(above, p.large[x]);
  const Sum rise = plus(t.hidden_at(x - 1)[at], p.large[x]);
  Sum fall_by_one = kNoCost<Sum>;
  if (at + 1 < t.lanes) {
    fall_by_one = plus(before[at + 1], p.small);
  }
  Sum rise_by_one = kNoCost<Sum>;
  if (x >= 2 && i >= 1) {
    const Sum skipped = plus(t.matched_at(x - 2)[at - 1], plus(p.small, p.occlusion));
    rise_by_one = minus(skipped, t.base[x - 1]);
  }
  const Sum least = std::min({before[at], fall_by_one, rise_by_one, fall, rise});
  if (least == kNoCost<Sum> || t.started[x] < least) {
    return {};
  }
  if (before[at] == least) {
    return {i, 0};
  }
  if (fall_by_one == least) {
    return {i + 1, 0};
  }
  if (rise_by_one == least) {
    return {i - 1, 1};
  }
  if (fall == least) {
    return {position(before, i + 1, static_cast<int>(t.lanes), above), 0};
  }
  return opening(t, x, i);
}

}  // namespace

template <typename Sum>
void dp_winners(std::span<const Sum> costs, int lanes, const DpPenalties<Sum>& penalties,
                DpTable<Sum>& table, std::span<std::int16_t> winners) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  const std::size_t n = winners.size();
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && costs.size() == n * count &&
             penalties.large.size() == n + 1 && table.lanes == count && table.started.size() >= n);
  std::ranges::fill(winners, kNoWinner);
  if (!any_preference(costs, lanes)) {
    return;
  }
  table.started[0] = 0;
  Sum ended = kNoCost<Sum>;
  std::size_t last = 0;  // the last match, if `ended` wins
  for (std::size_t x = 0; x < n; ++x) {
    if (x > 0) {
      const Sum ends = lowest_of(table.matched_at(x - 1), count);
      last = ends <= ended ? x - 1 : last;
      ended = plus(std::min(ends, ended), penalties.occlusion);
    }
    ended = advance(table, x, costs.subspan(x * count, count), penalties, ended);
  }
  std::size_t x = lowest_of(table.matched_at(n - 1), count) <= ended ? n - 1 : last;
  const Sum* const end = table.matched_at(x);
  const Sum least = lowest_of(end, count);
  int candidate = least == kNoCost<Sum> ? kNoWinner : position(end, 0, lanes, least);
  while (candidate != kNoWinner) {
    winners[x] = static_cast<std::int16_t>(candidate);
    if (x == 0) {
      return;
    }
    const Previous from = previous(table, x, candidate, penalties);
    candidate = from.candidate;
    x -= candidate == kNoWinner ? 0 : from.skipped + 1;
  }
}

void extend_background(std::span<std::int16_t> winners, std::span<std::uint8_t> filled) noexcept {
  STOF_CHECK(winners.size() == filled.size());
  std::ranges::fill(filled, std::uint8_t{0});
  for (std::size_t x = 0; x < winners.size();) {
    if (winners[x] != kNoWinner) {
      ++x;
      continue;
    }
    std::size_t end = x;
    while (end < winners.size() && winners[end] == kNoWinner) {
      ++end;
    }
    const std::int16_t before = x > 0 ? winners[x - 1] : kNoWinner;
    const std::int16_t after = end < winners.size() ? winners[end] : kNoWinner;
    const std::int16_t background = before == kNoWinner || after == kNoWinner
                                        ? std::max(before, after)
                                        : std::min(before, after);
    for (; x < end; ++x) {
      winners[x] = background;
      filled[x] = background == kNoWinner ? 0 : 1;
    }
  }
}

template void dp_winners(std::span<const std::uint16_t>, int, const DpPenalties<std::uint16_t>&,
                         DpTable<std::uint16_t>&, std::span<std::int16_t>) noexcept;
template void dp_winners(std::span<const std::uint32_t>, int, const DpPenalties<std::uint32_t>&,
                         DpTable<std::uint32_t>&, std::span<std::int16_t>) noexcept;

}  // namespace stof::lab
