#include "dsp/stereo/validation/window_sums.h"

#include "dsp/base/check.h"

namespace stof::dsp {

void WindowSums::enter(std::span<const std::int16_t> row) noexcept {
  STOF_CHECK(row.size() == columns_.size());
  for (std::size_t x = 0; x < row.size(); ++x) {
    columns_[x] += row[x];
  }
}

void WindowSums::leave(std::span<const std::int16_t> row) noexcept {
  STOF_CHECK(row.size() == columns_.size());
  for (std::size_t x = 0; x < row.size(); ++x) {
    columns_[x] -= row[x];
  }
}

std::span<const std::int32_t> WindowSums::sums() noexcept {
  const std::size_t n = columns_.size();
  if (n == 0) {
    return {};
  }
  const std::span<std::int32_t> padded = padded_.first(n + kWindow - 1);
  std::ranges::fill(padded.first(kBefore), columns_.front());
  std::ranges::copy(columns_, padded.subspan(kBefore).begin());
  std::ranges::fill(padded.subspan(kBefore + n), columns_.back());
  // Sums of 2, 4, 8 in place, then 24 = 8 + 8 + 8: no running sum along the row, so that the
  // compiler may use vectors.
  for (const std::size_t step : {std::size_t{1}, std::size_t{2}, std::size_t{4}}) {
    for (std::size_t k = 0; k + step < padded.size(); ++k) {
      padded[k] += padded[k + step];
    }
  }
  static_assert(kWindow == 24);
  for (std::size_t x = 0; x < n; ++x) {
    padded[x] += padded[x + 8] + padded[x + 16];
  }
  return padded.first(n);
}

}  // namespace stof::dsp
