#include "dsp/stereo/prefilter/equalise.h"

#include <algorithm>
#include <bit>
#include <cstddef>

#include "dsp/base/check.h"

namespace stof::dsp {
namespace {

constexpr int kGainBits = 12;
constexpr std::int64_t kOne = std::int64_t{1} << kGainBits;

// n = pixels, and n times the mean and n^2 times the variance: all exact.
struct Moments {
  std::int64_t n = 0;
  std::int64_t sum = 0;
  std::int64_t spread = 0;
};

Moments moments(ImageView<const std::uint8_t> picture) noexcept {
  Moments result{.n = std::int64_t{picture.width()} * picture.height()};
  std::int64_t squares = 0;
  for (int y = 0; y < picture.height(); ++y) {
    std::uint32_t row_sum = 0;
    std::uint32_t row_squares = 0;  // 65536 pixels of 255 fit
    for (const std::uint8_t grey : picture.row(y)) {
      row_sum += grey;
      row_squares += std::uint32_t{grey} * grey;
    }
    result.sum += row_sum;
    squares += row_squares;
  }
  result.spread = result.n * squares - result.sum * result.sum;
  return result;
}

// floor(sqrt(v)).
std::uint64_t root(std::uint64_t v) noexcept {
  std::uint64_t result = 0;
  for (int bit = (static_cast<int>(std::bit_width(v)) + 1) / 2; bit >= 0; --bit) {
    const std::uint64_t next = result | (std::uint64_t{1} << bit);
    if (next * next <= v) {
      result = next;
    }
  }
  return result;
}

GreyTable identity() noexcept {
  GreyTable table{};
  for (std::size_t v = 0; v < table.size(); ++v) {
    table[v] = static_cast<std::uint8_t>(v);
  }
  return table;
}

}  // namespace

GreyTable equalising_table(ImageView<const std::uint8_t> picture,
                           ImageView<const std::uint8_t> model) noexcept {
  const Moments from = moments(picture);
  const Moments to = moments(model);
  if (from.spread <= 0 || to.spread <= 0) {
    return identity();
  }
  // Deviations in 1/4096 grey levels: n^2 variance < 2^14 n^2, n < 2^24, so the roots fit.
  const auto deviation = [](const Moments& m) noexcept {
    return static_cast<std::int64_t>(root(static_cast<std::uint64_t>(m.spread))) * kOne / m.n;
  };
  const std::int64_t gain = std::clamp(
      deviation(to) * kOne / std::max<std::int64_t>(deviation(from), 1), kOne / 4, kOne * 4);
  const std::int64_t mean_from = from.sum * kOne / from.n;
  const std::int64_t mean_to = to.sum * kOne / to.n;
  GreyTable table{};
  for (std::size_t v = 0; v < table.size(); ++v) {
    const std::int64_t offset = static_cast<std::int64_t>(v) * kOne - mean_from;
    const std::int64_t grey = (mean_to * kOne + gain * offset + kOne * kOne / 2) >> (2 * kGainBits);
    table[v] = static_cast<std::uint8_t>(std::clamp<std::int64_t>(grey, 0, 255));
  }
  return table;
}

void apply_table(const GreyTable& table, ImageView<const std::uint8_t> picture, Rows rows,
                 ImageView<std::uint8_t> out) noexcept {
  STOF_CHECK(picture.width() <= out.width() && picture.height() <= out.height());
  for (int y = rows.begin; y < rows.end; ++y) {
    std::ranges::transform(picture.row(y), out.row(y).begin(),
                           [&](std::uint8_t grey) noexcept { return table[grey]; });
  }
}

}  // namespace stof::dsp
