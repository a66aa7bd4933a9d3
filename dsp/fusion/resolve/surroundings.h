#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdlib>

#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/fusion/interval/intersect.h"
#include "dsp/fusion/resolve/ambiguity_resolver.h"
#include "dsp/fusion/resolve/fused_pixels.h"
#include "dsp/fusion/resolve/matched_surface.h"
#include "dsp/fusion/resolve/pixel_set.h"
#include "dsp/fusion/resolve/surrounding_matches.h"

namespace stof::dsp {

// Pixels so near each other have one verdict, where they are alike.
inline constexpr std::size_t kJudgedTogether = 8;  // px
inline constexpr int kJudgedStep = 12;             // 1/16 px
// Matches around that are on the same side of what the PMD sees as an indistinct one, less those
// that are not: more of 16 do not err together.
inline constexpr int kOutvotes = 9;
// Of the 16 matches around an edge of the PMD, nearer by kMaxGuess.
inline constexpr int kNearerMatches = 3;
// To either side of the PMD's depth at an edge, of that: what a pixel beside the surface is off by.
inline constexpr int kEdgeShare = 32;
// What a doubtful match may be instead is kMaxGuess away at most, and that is a quarter of its
// depth.
inline constexpr int kFarthestDoubt = 4 * kMaxGuess;

// What the matches around the pixels of a row, in the rows above and below too, say of them.
template <typename Table>
class Surroundings : private FusedPixels {
 public:
  // view: whose row y is looked at; of an empty one nothing may be asked. table: of its matches.
  Surroundings(ImageView<const Disparity> view, int y, const Table& table,
               const FusedRow& out) noexcept
      : FusedPixels(out), view_(view), y_(y), table_(table) {}

  // Whether those around are on the side of a match that lies behind the PMD's interval, or before
  // it.
  bool outvotes_pmd(std::size_t x, const DepthRange& seen, bool behind) const noexcept {
    const SurroundingMatches around = matches(x, seen);
    return (behind ? around.behind - around.before
                   : around.before - around.within - around.behind) >= kOutvotes;
  }

  // Widens the interval of a match over what it may be instead; false: nothing is known of that, or
  // it is too far from it.
  bool cover_others(std::size_t x) const noexcept {
    const DepthInterval own = published(x);
    const DepthRange around = surrounding_surfaces(view_, static_cast<int>(x), y_, table_);
    const int nearer = out_.depth[x] - around.low;
    const int farther = around.high - out_.depth[x];
    if ((around.low >= own.low && around.high <= own.high) || out_.depth[x] > kFarthestDoubt ||
        nearer > kMaxGuess || farther > kMaxGuess) {
      return false;
    }
    widen(x, std::max(nearer, farther));
    return true;
  }

  // What the PMD alone says at its edges: nothing where something nearer lies beside it.
  void judge_edges(const PixelSet& edges) const noexcept {
    std::size_t end = 0;  // of what is judged together
    int judged = 0;
    bool nearer = false;
    edges.each(out_.depth.size(), [&](std::size_t x) noexcept {
      if (out_.source[x] != Source::kPmd) {
        return;
      }
      const int depth = out_.depth[x];
      if (x >= end || std::abs(depth - judged) * kEdgeShare > depth) {
        end = x + kJudgedTogether;
        judged = depth;
        nearer = matches(x, {depth - kMaxGuess, kMaxQuarterMm}).before >= kNearerMatches;
      }
      if (nearer) {
        drop(x, Source::kConflict, Cause::kMixedPixel);
      } else {
        widen(x, depth / kEdgeShare);
      }
    });
  }

 private:
  SurroundingMatches matches(std::size_t x, const DepthRange& range) const noexcept {
    return surrounding_matches(view_, static_cast<int>(x), y_, table_, range);
  }

  ImageView<const Disparity> view_;
  int y_;
  const Table& table_;
};

}  // namespace stof::dsp
