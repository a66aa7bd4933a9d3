#include "dsp/fusion/unwrap/decision/distance_votes.h"

#include <algorithm>

#include "dsp/base/index.h"

namespace stof::dsp {
namespace {

int cells(int size) noexcept { return (size + DistanceVotes::kCell - 1) / DistanceVotes::kCell; }

std::size_t elements(int width, int height, std::size_t bins) noexcept {
  return index(cells(width)) * index(cells(height)) * bins;
}

}  // namespace

DistanceVotes::DistanceVotes(int width, int height, std::uint32_t range, Arena& arena) noexcept
    : cells_x_(cells(width)), cells_y_(cells(height)) {
  int bits = 16;
  while ((std::uint32_t{1} << bits) > range / 6 && (kMaxQuarterMm >> (bits - 1)) < kMostBins) {
    --bits;
  }
  bin_bits_ = bits;
  bins_ = index(kMaxQuarterMm >> bits) + 3;
  votes_ = arena.take_passing<std::uint16_t>(elements(width, height, bins_));
  sums_ = arena.take_passing<std::uint16_t>(votes_.size());
  line_ = arena.take_passing<std::uint16_t>(elements(width, 1, bins_));
}

void DistanceVotes::clear() noexcept { std::ranges::fill(votes_, std::uint16_t{0}); }

void DistanceVotes::sum() noexcept {
  const std::size_t row = index(cells_x_) * bins_;
  for (int y = 0; y < cells_y_; ++y) {
    const std::span<const std::uint16_t> here = votes_.subspan(at(0, y), row);
    std::ranges::copy(here, line_.begin());
    for (const int other : {y - 1, y + 1}) {
      if (other >= 0 && other < cells_y_) {
        const std::span<const std::uint16_t> more = votes_.subspan(at(0, other), row);
        for (std::size_t i = 0; i < row; ++i) {
          line_[i] = static_cast<std::uint16_t>(line_[i] + more[i]);
        }
      }
    }
    const std::span<std::uint16_t> out = sums_.subspan(at(0, y), row);
    std::ranges::copy(line_, out.begin());
    for (std::size_t i = 0; i + bins_ < row; ++i) {
      out[i] = static_cast<std::uint16_t>(out[i] + line_[i + bins_]);
      out[i + bins_] = static_cast<std::uint16_t>(out[i + bins_] + line_[i]);
    }
  }
}

}  // namespace stof::dsp
