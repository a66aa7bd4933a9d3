#include "dsp/pmd/interval/fill_intervals.h"

#include <algorithm>
#include <cstddef>
#include <span>

#include "dsp/base/check.h"
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

}  // namespace

void fill_intervals(const PmdMaps& maps, Rows rows) noexcept {
  const int stride = maps.distance.width() + 2;
  STOF_CHECK(maps.distance.stride() == stride && maps.sigma.stride() == stride);
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
    const IntervalRows around{padded_row(maps.distance, y - 1), padded_row(maps.distance, y),
                              padded_row(maps.distance, y + 1), padded_row(maps.sigma, y - 1),
                              padded_row(maps.sigma, y),        padded_row(maps.sigma, y + 1)};
    best::interval(around, limits, flags, maps.low.row(y), maps.high.row(y));
  }
}

void drop_wrapped(const PmdMaps& maps) noexcept {
  for (int y = 0; y < maps.flags.height(); ++y) {
    const std::span<const std::uint8_t> flags = maps.flags.row(y);
    const std::span<QuarterMm> distance = maps.distance.row(y);
    const std::span<QuarterMm> sigma = maps.sigma.row(y);
    for (std::size_t x = 0; x < flags.size(); ++x) {
      const bool wrapped = (flags[x] & kPmdWrapped) != 0;
      distance[x] = wrapped ? kNoDepth : distance[x];
      sigma[x] = wrapped ? QuarterMm{0} : sigma[x];
    }
    if (!maps.long_distance.empty()) {
      const std::span<std::uint32_t> far = maps.long_distance.row(y);
      for (std::size_t x = 0; x < flags.size(); ++x) {
        far[x] = (flags[x] & kPmdWrapped) != 0 ? 0 : far[x];
      }
    }
  }
}

void refresh_intervals(const PmdMaps& maps) noexcept {
  fill_intervals(maps, maps.flags.rows());
  drop_wrapped(maps);
}

}  // namespace stof::dsp
