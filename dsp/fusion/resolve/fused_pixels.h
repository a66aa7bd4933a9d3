#pragma once

#include <algorithm>
#include <cstddef>

#include "dsp/base/fixed.h"
#include "dsp/fusion/interval/intersect.h"
#include "dsp/fusion/interval/stereo_interval.h"
#include "dsp/fusion/resolve/matched_surface.h"

namespace stof::dsp {

// What is published of the pixels of a row.
class FusedPixels {
 public:
  explicit FusedPixels(const FusedRow& out) noexcept : out_(out) {}

  void drop(std::size_t x, Source source, Cause cause) const noexcept {
    out_.depth[x] = kNoDepth;
    out_.width[x] = 0;
    out_.source[x] = source;
    out_.cause[x] = cause;
  }

  void put(std::size_t x, const DepthRange& range, Source source, Cause cause) const noexcept {
    out_.depth[x] = middle_of(range.low, range.high);
    out_.width[x] = width_of(range.low, range.high);
    out_.source[x] = source;
    out_.cause[x] = cause;
  }

  // Widens the interval of a published depth, which stays its middle.
  void widen(std::size_t x, int half) const noexcept {
    constexpr int kMostHalf = kMaxQuarterMm / 2;
    const int depth = out_.depth[x];
    out_.width[x] = static_cast<QuarterMm>(
        2 * std::min({std::max(out_.width[x] / 2, half), depth - 1, kMostHalf}));
  }

  DepthInterval published(std::size_t x) const noexcept {
    const int half = out_.width[x] / 2;
    return {static_cast<QuarterMm>(std::max(out_.depth[x] - half, 1)),
            static_cast<QuarterMm>(std::min(out_.depth[x] + half, int{kMaxQuarterMm}))};
  }

 protected:
  const FusedRow& out_;
};

}  // namespace stof::dsp
