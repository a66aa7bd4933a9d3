#include "dsp/pmd/interval/fill_intervals.h"

#include <algorithm>
#include <cstddef>
#include <span>

#include "dsp/base/check.h"
#include "dsp/pmd/interval/average_pairs.h"
#include "dsp/pmd/interval/interval.h"

namespace stof::dsp {
namespace {

// What neighbours say about a pixel that has a distance.
constexpr std::uint8_t kFromNeighbours = kPmdEdge | kPmdOutOfRange | kPmdWrapped;

// A row of pixels with its two neighbours outside.
std::span<const QuarterMm> padded_row(const ImageView<QuarterMm>& image, int y) noexcept {
  const std::span<const QuarterMm> row = image.row_clamped(y);
  return {row.data() - 1, row.size() + 2};
}

IntervalRows rows_around(const ImageView<QuarterMm>& distance, const ImageView<QuarterMm>& sigma,
                         int y) noexcept {
  return {padded_row(distance, y - 1), padded_row(distance, y), padded_row(distance, y + 1),
          padded_row(sigma, y - 1),    padded_row(sigma, y),    padded_row(sigma, y + 1)};
}

const ImageView<QuarterMm>& located_sigma(const PmdMaps& maps) noexcept {
  return maps.smoothed.empty() ? maps.sigma : maps.smoothed_sigma;
}

}  // namespace

IntervalRows located_rows(const PmdMaps& maps, int y) noexcept {
  return rows_around(maps.located(), located_sigma(maps), y);
}

void smooth_readings(const PmdMaps& maps) noexcept {
  if (maps.smoothed.empty()) {
    return;
  }
  const int last = maps.distance.height() - 1;
  for (const int y : {0, last}) {
    std::ranges::copy(maps.distance.row(y), maps.smoothed.row(y).begin());
    std::ranges::copy(maps.sigma.row(y), maps.smoothed_sigma.row(y).begin());
  }
  for (int y = 1; y < last; ++y) {
    best::average_pairs(rows_around(maps.distance, maps.sigma, y), maps.slope_q16,
                        maps.smoothed.row(y), maps.smoothed_sigma.row(y));
  }
}

void fill_intervals(const PmdMaps& maps, Rows rows) noexcept {
  const ImageView<QuarterMm>& located = maps.located();
  const ImageView<QuarterMm>& sigma = located_sigma(maps);
  const int stride = maps.distance.width() + 2;
  STOF_CHECK(maps.distance.stride() == stride && maps.sigma.stride() == stride);
  STOF_CHECK(located.stride() == stride && sigma.stride() == stride);
  const IntervalLimits limits{
      .range = static_cast<QuarterMm>(std::min<std::uint32_t>(maps.range, kMaxQuarterMm)),
      .widest = maps.widest,
      .slope_q16 = maps.slope_q16};
  for (int y = rows.begin; y < rows.end; ++y) {
    const std::span<const QuarterMm> distance = maps.distance.row(y);
    const std::span<std::uint8_t> flags = maps.flags.row(y);
    for (std::size_t x = 0; x < flags.size(); ++x) {
      const unsigned stale = distance[x] == kNoDepth ? 0U : unsigned{kFromNeighbours};
      flags[x] = static_cast<std::uint8_t>(flags[x] & ~stale);
    }
    best::interval(located_rows(maps, y), limits, flags, maps.low.row(y), maps.high.row(y));
  }
}

void drop_wrapped(const PmdMaps& maps) noexcept {
  const auto clear = [](const auto& image, std::size_t x, int y) noexcept {
    if (!image.empty()) {
      image.row(y)[x] = 0;
    }
  };
  for (int y = 0; y < maps.flags.height(); ++y) {
    const std::span<const std::uint8_t> flags = maps.flags.row(y);
    for (std::size_t x = 0; x < flags.size(); ++x) {
      if ((flags[x] & kPmdWrapped) == 0) {
        continue;
      }
      const QuarterMm distance = maps.distance.row(y)[x];
      // Of wide pixels most are edges, and none confirms anything.
      const bool tells = (flags[x] & kPmdEdge) == 0 || maps.smoothed.empty();
      if (distance != kNoDepth && tells && !maps.folded.empty()) {
        maps.folded.row(y)[x] = static_cast<QuarterMm>(distance % maps.range);
        maps.folded_sigma.row(y)[x] = maps.sigma.row(y)[x];
      }
      clear(maps.distance, x, y);
      clear(maps.sigma, x, y);
      clear(maps.smoothed, x, y);
      clear(maps.smoothed_sigma, x, y);
      clear(maps.long_distance, x, y);
    }
  }
}

void refresh_intervals(const PmdMaps& maps) noexcept {
  smooth_readings(maps);
  fill_intervals(maps, maps.flags.rows());
  drop_wrapped(maps);
}

}  // namespace stof::dsp
