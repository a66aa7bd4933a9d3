#pragma once

#include <algorithm>
#include <cstddef>

#include "dsp/fusion/interval/column_interval.h"
#include "dsp/fusion/interval/stereo_interval.h"

namespace stof::dsp {

// Depths, quarter mm.
struct DepthRange {
  int low = 1;
  int high = 0;
  constexpr bool empty() const noexcept { return low > high; }
};

constexpr DepthRange common(const DepthRange& a, const DepthRange& b) noexcept {
  return {std::max(a.low, b.low), std::min(a.high, b.high)};
}

// Where one disparity lies, for every column.
template <typename Table>
class MatchedSurface;

template <>
class MatchedSurface<DisparityTable> {
 public:
  MatchedSurface(const DisparityTable& table, int raw, int half) noexcept
      : interval_(table.at(raw, half)) {}
  DepthInterval at(std::size_t /*x*/) const noexcept { return interval_; }

 private:
  DepthInterval interval_;
};

template <>
class MatchedSurface<ColumnTables> {
 public:
  MatchedSurface(const ColumnTables& tables, int raw, int half) noexcept
      : tables_(tables), raw_(raw), half_(half) {}
  DepthInterval at(std::size_t x) const noexcept {
    return ref::column_interval_at(x, raw_, half_, tables_);
  }

 private:
  const ColumnTables& tables_;
  int raw_;
  int half_;
};

}  // namespace stof::dsp
