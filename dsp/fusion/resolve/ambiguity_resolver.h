#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/fusion/interval/column_interval.h"
#include "dsp/fusion/interval/intersect.h"
#include "dsp/fusion/interval/stereo_interval.h"
#include "dsp/fusion/resolve/match_evidence.h"

// Pixels where the PMD measured something and stereo did not, or contradicted it at an edge: the
// PMD pixel is many stereo pixels wide, and where it sees two surfaces its interval holds both. The
// matches around the pixel say where these surfaces are. Nothing is made up: a surface counts only
// where the PMD interval of the pixel allows it, and without a PMD interval there is no depth.
namespace stof::dsp {

struct AmbiguityRow {
  std::span<const Disparity> disparity;
  // Matches that were consistent, but did not stand out from their rivals; empty: there are none.
  std::span<const Disparity> weak;
  IntervalRow stereo;
  IntervalRow pmd;
  std::span<const QuarterMm> reading;  // where the PMD's reading lies; any, without an interval
  SupportRow support;
  std::span<const std::uint8_t> picture = {};  // left; may be empty
  // The whole view, of which `disparity` is row y, and who judges matches that nothing confirms;
  // nullptr: they are published.
  ImageView<const Disparity> view = {};
  int y = 0;
  ImageView<const std::uint8_t> whole = {};  // left picture, of which `picture` is row y, or empty
  const MatchEvidence* evidence = nullptr;
};

struct AmbiguityParams {
  std::int16_t infinity_raw = 0;  // the disparity of infinity, 1/16 px
  QuarterMm max_range = 0;
  QuarterMm pmd_range = 0;  // unambiguous range of the PMD; 0 = not to be considered
  int reach_px = 0;         // a surface further away than this is not in the PMD's interval
  bool wide_pmd = false;    // PMD pixels are too wide to see one surface mostly (is_fine)
  int doubt_px = 0;         // a nearer surface within this many pixels makes a guess one to drop
};

// How far a surface may lie from where its neighbour was matched: a fourteenth of the parallax
// (and so of the depth), at least 1 px.
inline constexpr int kResolvedShare = 14;
// At an edge, where the nearest surface is the better guess of two: a sixth.
inline constexpr int kMixedShare = 6;
// A PMD interval narrower than a twelfth of its depth is good enough alone.
inline constexpr int kNarrowShare = 12;
// A match stands for a surface that its neighbours belong to below this peak ratio: eight in ten of
// those that are less distinct than kSureRatio are right too.
inline constexpr std::uint8_t kNeighbourRatio = 184;
// At an edge of the PMD a match with a higher ratio may as well be of the other surface.
inline constexpr std::uint8_t kVagueRatio = 144;
// With such a ratio it may be anywhere in the PMD's interval without an edge, too.
inline constexpr std::uint8_t kVaguestRatio = 192;
// Where PMD pixels are wide, these contradict a match without an edge because they see several
// surfaces whose readings differ by less than their noise. A match before what they see is believed
// below the one ratio, 19 in 20 are right; one behind it below the other alone: with 60 a pane of
// glass is seen through more often.
inline constexpr std::uint8_t kSureBeforeRatio = 100;
inline constexpr std::uint8_t kSurestRatio = 40;
// Who takes the farther of two surfaces is wrong by at most that, or publishes nothing; quarter mm.
// At an edge without any match around, or of a vague match, the PMD's interval is what may be
// nearer.
inline constexpr int kMaxGuess = 4000;
inline constexpr int kMaxVagueGuess = 6000;
// The same of a match without rivals at an edge: a thin thing along the baseline has the matches of
// what is behind it, and the PMD's reading alone tells of it.
inline constexpr int kMaxSureGuess = 10000;
// A guess between two matches of one surface is moved towards the PMD's reading by at most a 64th
// of its depth.
inline constexpr int kPullShare = 64;
// One left of all matches by at most its depth times the pixels to the next match over kPullWay:
// who knows where the surface goes from there. Beyond kPullReach the reading alone tells.
inline constexpr int kPullReach = 56;  // px
inline constexpr int kPullWay = 1024;
// Neighbours this far apart, 1/16 px, are two surfaces.
inline constexpr int kSurfaceStep = 24;
// A hole that the nearer surface casts is as wide as the step of disparity; so much may be more.
inline constexpr int kShadowMargin = 3;
// The same where PMD pixels are wide: their intervals hold both surfaces, and matches end before
// the edge of what is nearer does. Beyond kShadowMargin the interval is that of the PMD at least.
inline constexpr int kWideShadowMargin = 24;

// First, where PMD pixels are wide, a kConflict by kContradiction becomes its match, kResolved by
// kMixedPixel, if its ratio is below kSureBeforeRatio and it lies before the PMD's interval, or
// below kSurestRatio and behind; unless both meet once the PMD's is moved by one pmd_range.
//
// Then pixels that only their match speaks for are judged by MatchEvidence, some that are near
// each other and alike (in the picture, too) together: kept, confirmed (a kStereo becomes kBoth,
// what both allow), contradicted (kConflict, kContradiction) or unsupported (kNone,
// kStereoAmbiguous). A doubtful one is unsupported, too, unless its interval can be widened over
// the matches around (surroundings.h). Where there is a view, a kResolved by kStereoAmbiguous (the
// PMD against an indistinct match) becomes kConflict by kContradiction if the matches around are on
// the match's side of the PMD's interval: behind, or nearer by more than kMaxGuess.
//
// Where the left picture is there, matches below kNeighbourRatio that lie before the edge of what
// they were matched to (fattened_edge.h), across pixels without one from L, kSurfaceStep behind it
// and a twentieth of its parallax, and look like L: if L meets the PMD's interval, what both allow,
// unless that is farther by more than kMaxGuess; kResolved, kOccluded, and the interval is widened
// over the match.
//
// Then each pixel whose source is kPmd with (high - low) kNarrowShare > low, or kConflict by
// kMixedPixel. L and R: disparities of the nearest matches below kNeighbourRatio to the left and
// right in the row that were published. The first of these whose interval meets the PMD's; what
// both allow is published:
//   L          where R is nearer by kSurfaceStep and within that step (+ kShadowMargin px) to the
//              right: what only the left camera sees belongs to the background; kResolved,
//              kOccluded. Where PMD pixels are wide, kWideShadowMargin
//   R          where there is no L and the match lies left of the right picture, kPullReach px
//              to the right at most: likewise
//   weak       the pixel's own match without distinction: kBoth, its interval widened over the
//              PMD's
// then, with pixels that were resolved by their weak match as neighbours too:
//   between    L and R less than kSurfaceStep apart, on the line between them; kResolved,
//              kStereoAmbiguous
//   nearest, then farthest of L and R (in the picture), within reach_px: where the PMD says
//              kPmdEdge; kResolved, kMixedPixel
//   reading    where there are a view and no L or no R, unless it is farther by more than kMaxGuess
//              than the PMD's near end, or the PMD says kPmdEdge: the PMD's reading, with an
//              interval as long as the PMD's; kResolved, kStereoAmbiguous
// Elsewhere a kPmd that is left has its reading as its depth, with an interval over the PMD's,
// where there is a view. Depths left of all matches (R where there is no L) and between two matches
// are moved towards the reading (kPullWay, kPullShare) unless the PMD says kPmdEdge, and their
// intervals are widened by as much. Other pixels, and those for which nothing fits, stay as they
// are, but for this: a kConflict whose intervals meet once the PMD's is moved by one pmd_range (or
// up to a sixteenth less: Z of a slanted ray) gets kRangeAmbiguous. All of one length.
//
// At an edge of the PMD (kPmdEdge) such a depth is a guess between two surfaces. Its interval is
// widened about it, at most to twice the depth, until it holds the PMD's. It is dropped (kConflict,
// kMixedPixel) where
//   L or R within doubt_px, as possible as what was chosen, is nearer by more than kMaxGuess;
//   or it lies between L and R, and the PMD's near end is nearer by more than kMaxVagueGuess;
//   or the PMD alone is left of it, and its near end is nearer by more than kMaxGuess;
//   or its match alone is left of it, and the PMD's near end is nearer by more than kMaxSureGuess.
// A kPmd at an edge, of fine pixels and where there is a view, is dropped likewise where matches
// around are nearer by more than kMaxGuess; else its interval is widened to kEdgeShare.
// A match at an edge with a ratio of kVagueRatio or more is widened, and dropped beyond
// kMaxVagueGuess, likewise; then it is no neighbour of others. Elsewhere one of kVaguestRatio or
// more is widened over the PMD's interval.
void resolve_ambiguities(const AmbiguityRow& row, const AmbiguityParams& params,
                         const DisparityTable& table, const FusedRow& out) noexcept;
void resolve_ambiguities(const AmbiguityRow& row, const AmbiguityParams& params,
                         const ColumnTables& tables, const FusedRow& out) noexcept;

}  // namespace stof::dsp
