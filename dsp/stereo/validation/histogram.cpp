#include "dsp/stereo/validation/histogram.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "dsp/base/check.h"

namespace stof::dsp {
namespace {

constexpr std::size_t kChunk = 64;
using Bins = std::array<std::uint16_t, kChunk>;

// Which count a disparity belongs to, invalid ones included: the one of the whole disparity, of
// which `first` has count 0 and `last` the last one.
struct Range {
  std::int16_t first;
  std::int16_t last;

  std::uint16_t bin(Disparity disparity) const noexcept {
    const auto below = static_cast<std::int16_t>(disparity.raw >> Disparity::kFractionBits);
    const int half = (disparity.raw >> (Disparity::kFractionBits - 1)) & 1;
    const auto whole = static_cast<std::int16_t>(below + half);
    return static_cast<std::uint16_t>(std::min(std::max(whole, first), last) - first);
  }
  // Without branches, so that compilers make vectors of it.
  void bins(const Disparity* disparities, Bins& out) const noexcept {
    for (std::size_t k = 0; k < kChunk; ++k) {
      out[k] = bin(disparities[k]);
    }
  }
};

Range range_of(int min_disparity, std::size_t counts) noexcept {
  constexpr int kFarthest = std::numeric_limits<std::int16_t>::max();
  const int last = min_disparity + static_cast<int>(counts) - 1;
  STOF_CHECK(min_disparity >= -kFarthest && last <= kFarthest);
  return {static_cast<std::int16_t>(min_disparity), static_cast<std::int16_t>(last)};
}

// Adds every pixel of a row, and returns how many are not valid.
std::uint32_t add_row(std::span<const Disparity> row, const Range& range,
                      std::uint32_t* counts) noexcept {
  std::uint32_t invalid = 0;
  std::size_t x = 0;
  for (Bins bins; x + kChunk <= row.size(); x += kChunk) {
    range.bins(&row[x], bins);
    for (const std::uint16_t bin : bins) {
      ++counts[bin];
    }
  }
  for (; x < row.size(); ++x) {
    ++counts[range.bin(row[x])];
  }
  for (const Disparity disparity : row) {
    invalid += disparity.valid() ? 0U : 1U;
  }
  return invalid;
}

void drop_row(std::span<Disparity> row, const Range& range, const std::uint32_t* rare) noexcept {
  constexpr std::int16_t kNone = Disparity::none().raw;
  std::size_t x = 0;
  for (Bins bins; x + kChunk <= row.size(); x += kChunk) {
    Disparity* const some = &row[x];
    range.bins(some, bins);
    for (std::size_t k = 0; k < kChunk; ++k) {
      some[k].raw = rare[bins[k]] != 0 ? kNone : some[k].raw;
    }
  }
  for (; x < row.size(); ++x) {
    row[x].raw = rare[range.bin(row[x])] != 0 ? kNone : row[x].raw;
  }
}

}  // namespace

void drop_rare(ImageView<Disparity> disparities, int min_disparity, int permille,
               std::span<std::uint32_t> counts) noexcept {
  STOF_CHECK(permille >= 0 && permille <= 1000 && !counts.empty());
  std::ranges::fill(counts, 0U);
  const Range range = range_of(min_disparity, counts.size());
  std::uint32_t invalid = 0;
  for (int y = 0; y < disparities.height(); ++y) {
    invalid += add_row(disparities.row(y), range, counts.data());
  }
  counts[range.bin(Disparity::none())] -= invalid;
  const std::uint64_t pixels = static_cast<std::uint64_t>(disparities.width()) *
                               static_cast<std::uint64_t>(disparities.height());
  const std::uint64_t least = pixels * static_cast<std::uint64_t>(permille);
  for (std::uint32_t& count : counts) {
    count = std::uint64_t{count} * 1000U < least ? 1 : 0;  // whether it is rare
  }
  for (int y = 0; y < disparities.height(); ++y) {
    drop_row(disparities.row(y), range, counts.data());
  }
}

}  // namespace stof::dsp
