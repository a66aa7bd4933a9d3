#include "dsp/fusion/temporal/temporal_filter.h"

#include "dsp/base/check.h"

namespace stof::dsp {

TemporalFilter::TemporalFilter(int width, int height, const TemporalParams& params,
                               Arena& arena) noexcept
    : params_(params),
      mean_(arena.take_filled_image(width, height, kNoDepth)),
      scatter_(arena.take_filled_image(width, height, std::uint16_t{0})),
      tally_(arena.take_filled_image(width, height, std::uint8_t{0})),
      kind_(arena.take_filled_image(width, height, std::uint8_t{0})) {
  STOF_CHECK(params.frames >= 1 && params.frames <= kMostFrames && params.max_step <= kMostStep);
}

void TemporalFilter::filter(int y, std::span<const std::uint8_t> marks,
                            const DepthMap& map) noexcept {
  best::temporal_row({.changed = marks,
                      .source = map.source.row(y),
                      .depth = map.depth.row(y),
                      .width = map.width.row(y)},
                     params_,
                     {.mean = mean_.row(y),
                      .scatter = scatter_.row(y),
                      .tally = tally_.row(y),
                      .kind = kind_.row(y)});
}

}  // namespace stof::dsp
