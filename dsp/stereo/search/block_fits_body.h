#pragma once

#include "dsp/stereo/search/block_winners_body.h"

// The second step for a chunk that was searched: winners that are none, and fits.
namespace stof::dsp::block_winners_body {

inline bool all_tie(const std::uint16_t* sums, Limits exist, int shift) noexcept {
  for (int i = exist.begin + 1; i < exist.end; ++i) {
    if (sums[i] >> shift != sums[exist.begin] >> shift) {
      return false;
    }
  }
  return true;
}

template <typename Isa>
void Pass<Isa>::finish(std::size_t x, std::size_t count) noexcept {
  // A tie of all has the first candidate for winner.
  if (chunk_.has_first || !whole(row_, x, count)) {
    drop_ties(x, count);
  }
  if (!out_.margins.empty()) {
    find_margins(x, count);
  }
  keeps_costs() ? fit<0>(x, count) : fit<3>(x, count);
}

template <typename Isa>
void Pass<Isa>::drop_ties(std::size_t x, std::size_t count) noexcept {
  const int shift = keeps_costs() ? 0 : 3;
  for (std::size_t p = 0; p < count; ++p) {
    std::int16_t& winner = chunk_.winners[p];
    const Limits exist = limits(row_, x + p);
    if (chunk_.costs[p] == kNone ||
        (winner <= exist.begin && all_tie(sums(x) + p * lanes_, exist, shift))) {
      winner = kNoWinner;
    }
  }
}

// Below 100 * 256 * 7710 < 2^31.
template <typename Isa>
void Pass<Isa>::find_margins(std::size_t x, std::size_t count) noexcept {
  std::array<std::int32_t, kChunk> offered;
  offered.fill(row_.lanes);
  if (!whole(row_, x, count)) {
    for (std::size_t p = 0; p < count; ++p) {
      const Limits exist = limits(row_, x + p);
      offered[p] = std::max(exist.end - exist.begin, 0);
    }
  }
  std::array<std::int16_t, kChunk> margins;
  for (std::size_t p = 0; p < kChunk; ++p) {
    const std::int32_t lead = row_.margin.percent * static_cast<std::int32_t>(chunk_.totals[p]) -
                              100 * offered[p] * chunk_.costs[p];
    const std::int32_t margin = std::clamp(lead >> row_.margin.shift, -32767, 32767);
    margins[p] = static_cast<std::int16_t>(chunk_.winners[p] == kNoWinner ? 0 : margin);
  }
  std::ranges::copy(std::span(margins).first(count), out_.margins.subspan(x).begin());
}

template <typename Isa>
template <int kShift>
void Pass<Isa>::fit(std::size_t x, std::size_t count) noexcept {
  static_assert(sizeof(Disparity) == sizeof(std::int16_t));
  std::int16_t* const winners = out_.winners.data() + x;
  Disparity* const fitted = out_.fitted.data() + x;
  std::size_t p = 0;
  for (; p + Isa::kColumns <= count; p += Isa::kColumns) {
    fit_some<kShift, true>(x, p, Isa::kColumns, winners + p, &fitted[p].raw);
  }
  if (p < count) {
    const std::size_t some = count - p;
    std::int16_t rest[2][Isa::kColumns];
    fit_some<kShift, false>(x, p, some, rest[0], rest[1]);
    std::memcpy(winners + p, rest[0], some * sizeof(std::int16_t));
    std::memcpy(fitted + p, rest[1], some * sizeof(std::int16_t));
  }
}

// Those beyond `count` mean nothing.
template <typename Isa>
template <int kShift, bool kAll>
void Pass<Isa>::fit_some(std::size_t x, std::size_t p, std::size_t count, std::int16_t* kept,
                         std::int16_t* fitted) noexcept {
  const std::uint16_t* before = sums(x) + p * lanes_ - 1;
  const std::int16_t* const winners = chunk_.winners.data() + p;
  const std::uint16_t* around[Isa::kColumns];
  for (std::size_t k = 0; k < Isa::kColumns; ++k) {
    const std::size_t pixel = kAll ? k : std::min(k, count - 1);  // the last that there is
    around[k] = before + winners[pixel];
    before += kAll || k + 1 < count ? lanes_ : 0;
  }
  Isa::template fit<kShift>(row_, around, chunk_.costs.data() + p, winners, kept, fitted);
}

template <typename Isa>
void pass(const BlockPixels& pixels, const BlockRow& row, std::span<std::uint16_t> columns,
          const BlockMatches& out) noexcept {
  const std::size_t n = pixels.new_left.size();
  const auto lanes = static_cast<std::size_t>(row.lanes);
  STOF_CHECK(lanes >= 16 && lanes % 16 == 0 && lanes <= kMostLanes && row.disparities >= 1 &&
             row.disparities <= row.lanes && row.block_width >= 1 && columns.size() == n * lanes);
  STOF_CHECK(out.winners.size() + static_cast<std::size_t>(row.block_width) == n + 1 &&
             out.fitted.size() == out.winners.size());
  STOF_CHECK(out.costs.empty() || out.costs.size() == out.winners.size() * lanes);
  STOF_CHECK(out.margins.empty() ||
             (out.margins.size() == out.winners.size() && !out.costs.empty() &&
              row.margin.percent <= 100 && row.margin.shift >= 0 && row.margin.shift <= 30));
  STOF_CHECK(pixels.old_left.size() == n && pixels.new_right.size() == n + lanes - 1 &&
             pixels.old_right.size() == n + lanes - 1);
  Pass<Isa>(pixels, row, columns.data(), out).go();
  mutate(columns);
  mutate(out.winners);
  mutate(out.costs);
  mutate(out.margins);
  if (!out.fitted.empty()) {
    mutate(&out.fitted.front().raw);
  }
}

}  // namespace stof::dsp::block_winners_body
