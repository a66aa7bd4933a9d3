#include "dsp/fusion/temporal/steady_filter.h"

#include <algorithm>

#include "dsp/fusion/temporal/picture_change.h"

namespace stof::dsp {

SteadyFilter::SteadyFilter(int width, int height, QuarterMm max_range, Arena& arena) noexcept
    : limits_{.max_range = std::max(max_range, QuarterMm{1})},
      seen_(arena.take_filled_image(width, height, kNoDepth)),
      tally_(arena.take_filled_image(width, height, std::uint8_t{0})) {}

void SteadyFilter::filter(int y, std::span<const std::uint8_t> marks, const SensorIntervals& said,
                          const FusedRow& fused) noexcept {
  best::steady_row({.changed = marks,
                    .changes = PictureChange::kCell,
                    .stereo = said.stereo,
                    .pmd = said.pmd,
                    .fused = fused,
                    .late = said.late},
                   limits_, {.depth = seen_.row(y), .tally = tally_.row(y)});
}

}  // namespace stof::dsp
