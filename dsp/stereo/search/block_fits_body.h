#pragma once

#include "dsp/stereo/search/block_winners_body.h"

// The second step for a chunk that was searched: winners that are none, and fits.
namespace stof::dsp::block_winners_body {

// The same where all candidates exist, four at a time.
inline bool whole_tie(const std::uint16_t* sums, std::size_t lanes, int shift) noexcept {
  constexpr std::uint64_t kEach = 0x0001'0001'0001'0001;
  const std::uint64_t mask = kEach * ((0xFFFFU << shift) & 0xFFFFU);
  const std::uint64_t first = (kEach * sums[0]) & mask;
  for (std::size_t i = 0; i < lanes; i += 4) {
    std::uint64_t four = 0;
    std::memcpy(&four, sums + i, sizeof four);
    if ((four & mask) != first) {
      return false;
    }
  }
  return true;
}
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
  if (whole(row_, x, count)) {  // each column has all candidates, and so a cost
    for (std::size_t p = 0; p < count; ++p) {
      if (chunk_.winners[p] == 0 && whole_tie(sums(x) + p * lanes_, lanes_, shift)) {
        chunk_.winners[p] = kNoWinner;
      }
    }
    return;
  }
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
  const std::size_t lanes = lanes_;
  const std::uint16_t* columns = sums(x);
  Places places;
  for (std::size_t k = 0; k < Isa::kColumns; ++k) {
    places[k] = static_cast<std::uint16_t>(k * lanes);
  }
  std::size_t p = 0;
  for (; p + Isa::kColumns <= count; p += Isa::kColumns, columns += Isa::kColumns * lanes) {
    Isa::template fit<kShift>(row_, columns, places, chunk_.costs.data() + p,
                              chunk_.winners.data() + p, winners + p, &fitted[p].raw);
  }
  if (p < count) {
    // Columns that there are not are the last one.
    const std::size_t some = count - p;
    std::int16_t rest[3][Isa::kColumns];
    for (std::size_t k = 0; k < Isa::kColumns; ++k) {
      const std::size_t column = std::min(k, some - 1);
      places[k] = places[column];
      rest[0][k] = chunk_.winners[p + column];
    }
    Isa::template fit<kShift>(row_, columns, places, chunk_.costs.data() + p, rest[0], rest[1],
                              rest[2]);
    std::memcpy(winners + p, rest[1], some * sizeof(std::int16_t));
    std::memcpy(fitted + p, rest[2], some * sizeof(std::int16_t));
  }
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
