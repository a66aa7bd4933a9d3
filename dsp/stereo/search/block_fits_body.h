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
  if (suspicious(x, count)) {
    drop_ties(x, count);
  }
  std::memcpy(out_.winners.data() + x, chunk_.winners.data(), count * sizeof(std::int16_t));
  for (std::size_t p = 0; p < count; p += 8) {
    keeps_costs() ? fit<0>(sums(x), p, count) : fit<3>(sums(x), p, count);
  }
  for (std::size_t p = 0; p < count; ++p) {
    out_.fitted[x + p].raw = chunk_.fitted[p];
  }
}

// Whether a winner may be none: a tie of all has the first candidate for winner.
template <typename Isa>
bool Pass<Isa>::suspicious(std::size_t x, std::size_t count) const noexcept {
  int least = 1;
  for (const std::int16_t winner : chunk_.winners) {  // what is beyond count does no harm
    least = std::min<int>(least, winner);
  }
  return least <= 0 || !whole(row_, x, count);
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

// Eight fits, of which those beyond `count` mean nothing.
template <typename Isa>
template <int kShift>
void Pass<Isa>::fit(const std::uint16_t* sums, std::size_t p, std::size_t count) noexcept {
  const std::uint16_t* around[8];
  const auto fit_eight = [&] noexcept {
    Isa::template fit<kShift>(row_, around, chunk_.costs.data() + p, chunk_.winners.data() + p,
                              chunk_.fitted.data() + p);
  };
  if (p + 8 <= count) {
    for (std::size_t k = 0; k < 8; ++k) {
      around[k] = sums + (p + k) * lanes_ + chunk_.winners[p + k] - 1;
    }
    fit_eight();  // not shared with below: the compiler keeps the places in registers
    return;
  }
  for (std::size_t k = 0; k < 8; ++k) {  // nothing is read behind the last one
    const std::size_t pixel = std::min(p + k, count - 1);
    around[k] = sums + pixel * lanes_ + chunk_.winners[pixel] - 1;
  }
  fit_eight();
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
  STOF_CHECK(pixels.old_left.size() == n && pixels.new_right.size() == n + lanes - 1 &&
             pixels.old_right.size() == n + lanes - 1);
  Pass<Isa>(pixels, row, columns.data(), out).go();
  mutate(columns);
  mutate(out.winners);
  mutate(out.costs);
  if (!out.fitted.empty()) {
    mutate(&out.fitted.front().raw);
  }
}

}  // namespace stof::dsp::block_winners_body
