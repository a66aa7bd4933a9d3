#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/base/index.h"
#include "dsp/fusion/resolve/matched_surface.h"

namespace stof::dsp {

// How far from a pixel the matches lie that are asked about it, px: eight at each distance.
inline constexpr std::array<int, 2> kSupportRings{4, 8};

// Calls visit(column, match) for the matches around (x, y), up to 16.
template <typename Visit>
void each_surrounding_match(ImageView<const Disparity> view, int x, int y, Visit visit) noexcept {
  constexpr int kFarthest = kSupportRings.back();
  const auto ask = [&visit](int column, Disparity match) noexcept {
    if (match.valid()) {
      visit(column, match);
    }
  };
  if (x >= kFarthest && x + kFarthest < view.width() && y >= kFarthest &&
      y + kFarthest < view.height()) {  // the picture has all of them
    const Disparity* const here = &view.row(y)[index(x)];
    for (const int step : kSupportRings) {
      for (const Disparity* const row :
           {here - step * view.stride(), here + step * view.stride()}) {
        ask(x - step, row[-step]);
        ask(x, row[0]);
        ask(x + step, row[step]);
      }
      ask(x - step, here[-step]);
      ask(x + step, here[step]);
    }
    return;
  }
  for (const int step : kSupportRings) {
    for (const int row : {y - step, y, y + step}) {
      if (row < 0 || row >= view.height()) {
        continue;
      }
      const std::span<const Disparity> matches = view.row(row);
      for (const int column : {x - step, x, x + step}) {
        const bool own = row == y && column == x;
        if (!own && column >= 0 && column < view.width()) {
          ask(column, matches[index(column)]);
        }
      }
    }
  }
}

// Of the matches around a pixel, how many lie before a range of depths, in it and behind it.
struct SurroundingMatches {
  int before = 0;
  int within = 0;
  int behind = 0;
};

// table: of the matches of the view. (x, y) lies in it.
template <typename Table>
SurroundingMatches surrounding_matches(ImageView<const Disparity> view, int x, int y,
                                       const Table& table, const DepthRange& range) noexcept {
  SurroundingMatches found;
  each_surrounding_match(view, x, y, [&](int column, Disparity match) noexcept {
    const DepthInterval at = MatchedSurface<Table>(table, match.raw, 0).at(index(column));
    if (at.high == 0 || at.low > range.high) {  // 0: beyond the farthest that is told
      ++found.behind;
    } else {
      ++(at.high < range.low ? found.before : found.within);
    }
  });
  return found;
}

// From the nearest to the farthest of the matches around a pixel; empty where there is none.
template <typename Table>
DepthRange surrounding_surfaces(ImageView<const Disparity> view, int x, int y,
                                const Table& table) noexcept {
  DepthRange found{kMaxQuarterMm, 0};
  each_surrounding_match(view, x, y, [&](int column, Disparity match) noexcept {
    const DepthInterval at = MatchedSurface<Table>(table, match.raw, 0).at(index(column));
    const bool beyond = at.high == 0;
    found.low = std::min<int>(found.low, beyond ? kMaxQuarterMm : at.low);
    found.high = std::max<int>(found.high, beyond ? kMaxQuarterMm : at.high);
  });
  return found;
}

// The same where one disparity lies at one depth in every column: the least and the greatest of
// them say it.
inline DepthRange surrounding_surfaces(ImageView<const Disparity> view, int x, int y,
                                       const DisparityTable& table) noexcept {
  int least = std::numeric_limits<int>::max();
  int greatest = std::numeric_limits<int>::min();
  each_surrounding_match(view, x, y, [&](int /*column*/, Disparity match) noexcept {
    least = std::min<int>(least, match.raw);
    greatest = std::max<int>(greatest, match.raw);
  });
  if (least > greatest) {
    return {kMaxQuarterMm, 0};
  }
  if (greatest - table.first_raw >= table.size()) {  // not of this table
    return surrounding_surfaces<DisparityTable>(view, x, y, table);
  }
  const DepthInterval nearest = table.at(greatest, 0);
  const DepthInterval farthest = table.at(least, 0);
  return {nearest.high == 0 ? kMaxQuarterMm : nearest.low,
          farthest.high == 0 ? kMaxQuarterMm : farthest.high};
}

}  // namespace stof::dsp
