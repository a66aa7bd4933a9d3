#include "dsp/fusion/temporal/steady_filter.h"

#include <algorithm>
#include <limits>
#include <span>

namespace stof::dsp {

SteadyFilter::SteadyFilter(int width, int height, QuarterMm max_range, Arena& arena,
                           int threads) noexcept
    : limits_{.max_range = std::max(max_range, QuarterMm{1})},
      change_(width, height, arena),
      seen_(arena.take_image<QuarterMm>(width, height)),
      tally_(arena.take_image<std::uint8_t>(width, height)),
      changed_(arena.take_image<std::uint8_t>(width, threads)) {
  if (!arena.is_measuring()) {
    forget();
  }
}

void SteadyFilter::forget() noexcept {
  change_.forget();
  begin();
}

void SteadyFilter::begin() noexcept {
  frames_ = 0;
  for (int y = 0; y < tally_.height(); ++y) {
    std::ranges::fill(seen_.row(y), kNoDepth);
    std::ranges::fill(tally_.row(y), std::uint8_t{0});
  }
}

void SteadyFilter::look(ImageView<const std::uint8_t> left) noexcept {
  if (!change_.look(left)) {
    begin();
  }
  frames_ = static_cast<std::uint16_t>(
      std::min<int>(frames_ + 1, std::numeric_limits<std::uint16_t>::max()));
}

void SteadyFilter::filter(int y, int thread, const IntervalRow& stereo, const IntervalRow& pmd,
                          const FusedRow& fused) noexcept {
  const std::span<std::uint8_t> changed = changed_.row(thread);
  std::ranges::fill(changed, std::uint8_t{0});
  change_.add_to(y, changed);
  best::steady_row({.changed = changed, .stereo = stereo, .pmd = pmd, .fused = fused}, limits_,
                   {.depth = seen_.row(y), .tally = tally_.row(y)});
}

}  // namespace stof::dsp
