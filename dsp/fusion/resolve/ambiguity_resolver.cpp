#include "dsp/fusion/resolve/ambiguity_resolver.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "dsp/fusion/resolve/ambiguity_masks.h"
#include "dsp/fusion/resolve/fattened_edge.h"
#include "dsp/fusion/resolve/fused_pixels.h"
#include "dsp/fusion/resolve/open_run.h"
#include "dsp/fusion/resolve/pixel_set.h"
#include "dsp/fusion/resolve/surroundings.h"
#include "dsp/pmd/pmd_maps.h"
#include "dsp/stereo/match_params.h"

namespace stof::dsp {
namespace {

// Of a part of the way between two matches: less than kSurfaceStep times as much fits int.
constexpr int kPartBits = 20;

template <typename Table>
class AmbiguityResolver : private FusedPixels {
 public:
  AmbiguityResolver(const AmbiguityRow& row, const AmbiguityParams& params, const Table& table,
                    const FusedRow& out) noexcept
      : FusedPixels(out),
        row_(row),
        params_(params),
        table_(table),
        around_(row.view, row.y, table, out) {}

  void run() noexcept {
    const std::size_t n = row_.disparity.size();
    best::ambiguity_masks({row_.disparity, row_.weak, row_.support, row_.stereo, row_.pmd,
                           out_.source, out_.cause, params_.max_range, params_.pmd_range},
                          {open_.words(n), matched_.words(n), folded_.words(n), weak_.words(n),
                           edge_.words(n), alone_.words(n), vague_.words(n), unsure_.words(n)});
    std::ranges::fill(confirmed_.words(n), 0U);
    if (params_.wide_pmd) {
      believe_surest_matches();
    }
    drop_far_matches();
    judge_alone();
    judge_vague();
    if (!row_.view.empty()) {
      judge_unsure();
    }
    if (!row_.picture.empty()) {
      cut_edges();
    }
    each_run([this](const OpenRun& run) noexcept {
      resolve_shadow(run);
      confirm_weak(run);
    });
    matched_.unite(confirmed_, n);
    each_run([this](const OpenRun& run) noexcept {
      resolve_gap(run);
      resolve_edges(run);
      if (!row_.view.empty()) {
        take_readings(run);
      }
    });
    if (!row_.view.empty() && !params_.wide_pmd) {
      around_.judge_edges(edge_);
    }
    drop_wide_edges();
    folded_.each(n, [this](std::size_t x) noexcept {
      if (out_.source[x] == Source::kConflict) {
        out_.cause[x] = Cause::kRangeAmbiguous;
      }
    });
  }

 private:
  Disparity match_at(std::size_t x) const noexcept {
    return row_.disparity[x].valid() ? row_.disparity[x] : row_.weak[x];
  }

  // Calls resolve(run) for the runs of open pixels, from left to right.
  template <typename Resolve>
  void each_run(Resolve resolve) noexcept {
    const std::size_t n = row_.disparity.size();
    std::size_t behind = 0;
    for (std::size_t x = open_.next(0, n); x < n; x = open_.next(behind, n)) {
      behind = open_.next_without(x, n);
      OpenRun run;
      run.begin = x;
      run.end = behind;
      run.left_at = matched_.before(x);
      run.right_at = matched_.next(behind, n);
      run.left = run.left_at < x ? match_at(run.left_at) : Disparity::none();
      run.right = run.right_at < n ? match_at(run.right_at) : Disparity::none();
      resolve(run);
    }
  }

  DepthRange pmd(std::size_t x) const noexcept {
    return {std::max<int>(row_.pmd.low[x], 1), std::min<int>(row_.pmd.high[x], params_.max_range)};
  }

  MatchedSurface<Table> surface(int raw, int share = kResolvedShare) const noexcept {
    const int half =
        std::clamp((raw - params_.infinity_raw) / share, int{Disparity::kOne}, kMostHalfWidth);
    return {table_, raw, half};
  }

  // Over the PMD's.
  void cover_pmd(std::size_t x) noexcept {
    const DepthRange seen = pmd(x);
    widen(x, std::max(out_.depth[x] - seen.low, seen.high - out_.depth[x]));
  }

  // Moves a depth towards the PMD's reading, by at most so much, within its interval, which is
  // widened by as much: what was in it stays in it.
  void pull(std::size_t x, int most) noexcept {
    if (edge_.has(x)) {  // a mixture
      return;
    }
    const int from = out_.depth[x];
    const int reach = std::min(most, out_.width[x] / 2);
    const int depth = std::clamp<int>(row_.reading[x], from - reach, from + reach);
    const int half = out_.width[x] / 2 + std::abs(depth - from);
    out_.depth[x] = static_cast<QuarterMm>(depth);
    widen(x, half);
  }

  // Whether a surface beside the pixel, as possible as the published one, is much nearer.
  bool may_be_nearer(std::size_t x, const OpenRun& run) const noexcept {
    const auto nearer = [&](Disparity match, int away) noexcept {
      if (!match.valid() || away > params_.doubt_px) {
        return false;
      }
      const DepthInterval interval = surface(match.raw).at(x);
      const DepthRange both = common({std::max<int>(interval.low, 1), interval.high}, pmd(x));
      return !both.empty() && out_.depth[x] - middle_of(both.low, both.high) > kMaxGuess;
    };
    return nearer(run.left, run.to_left(x)) || nearer(run.right, run.to_right(x));
  }

  // Against readings of wide pixels that call themselves no edge.
  void believe_surest_matches() noexcept {
    for (std::size_t x = 0; x < row_.disparity.size(); ++x) {
      if (out_.cause[x] != Cause::kContradiction || folded_.has(x)) {
        continue;
      }
      const bool behind = row_.stereo.low[x] > row_.pmd.high[x];
      if (row_.support.ratio[x] >= (behind ? kSurestRatio : kSureBeforeRatio)) {
        continue;
      }
      put(x,
          {std::max<int>(row_.stereo.low[x], 1),
           std::min<int>(row_.stereo.high[x], params_.max_range)},
          Source::kResolved, Cause::kMixedPixel);
      alone_.add(x);
      matched_.add(x);
    }
  }

  // Matches against a mixed reading that may be of what is far behind it.
  void drop_far_matches() noexcept {
    const std::size_t n = row_.disparity.size();
    alone_.each(n, [this](std::size_t x) noexcept {
      if (out_.source[x] == Source::kResolved && out_.depth[x] - pmd(x).low > kMaxSureGuess) {
        drop(x, Source::kConflict, Cause::kMixedPixel);
        matched_.remove(x);
        alone_.remove(x);
      }
    });
  }

  // Where nothing but the match was known.
  void judge_alone() noexcept {
    const std::size_t n = row_.disparity.size();
    if (row_.evidence == nullptr || !row_.evidence->judges()) {
      return;
    }
    MatchEvidence::Result said{};
    std::size_t end = 0;  // of what may be judged together
    bool sure = false;
    int raw = 0;
    int grey = 0;
    alone_.each(n, [&](std::size_t x) noexcept {
      const int here = row_.picture.empty() ? 0 : row_.picture[x];
      if (x >= end || is_sure(x) != sure || std::abs(row_.disparity[x].raw - raw) > kJudgedStep ||
          std::abs(here - grey) >= kEdgeStep) {
        end = x + kJudgedTogether;
        sure = is_sure(x);
        raw = row_.disparity[x].raw;
        grey = here;
        said = row_.evidence->judge({.x = static_cast<int>(x),
                                     .y = row_.y,
                                     .disparity = row_.disparity[x],
                                     .ratio = row_.support.ratio[x],
                                     .interval = published(x)},
                                    {row_.view, row_.whole});
      }
      finish_alone(x, said);
    });
  }

  void finish_alone(std::size_t x, const MatchEvidence::Result& said) noexcept {
    switch (said.verdict) {
      case MatchEvidence::Verdict::kConfirmed:
      case MatchEvidence::Verdict::kKept:
      case MatchEvidence::Verdict::kAllowed:
        if (out_.source[x] == Source::kResolved) {  // against a mixed reading
          cover_pmd(x);
        } else if (said.verdict == MatchEvidence::Verdict::kConfirmed) {
          const auto [low, high] = published(x);
          const DepthRange both = common({low, high}, {said.reading.low, said.reading.high});
          if (!both.empty()) {
            put(x, both, Source::kBoth, Cause::kNone);
          }
        }
        return;
      case MatchEvidence::Verdict::kDoubtful:
        if (around_.cover_others(x)) {
          return;
        }
        drop(x, Source::kNone, Cause::kStereoAmbiguous);
        break;
      case MatchEvidence::Verdict::kContradicted:
        drop(x, Source::kConflict, Cause::kContradiction);
        break;
      case MatchEvidence::Verdict::kUnsupported:
        drop(x, Source::kNone, Cause::kStereoAmbiguous);
        break;
    }
    matched_.remove(x);
  }

  bool is_sure(std::size_t x) const noexcept { return row_.support.ratio[x] < kSureRatio; }

  // Matches that may be of the other surface of an edge of the PMD, or of any.
  void judge_vague() noexcept {
    const std::size_t n = row_.disparity.size();
    vague_.each(n, [this](std::size_t x) noexcept {
      if (edge_.has(x) && out_.depth[x] - pmd(x).low > kMaxVagueGuess) {
        drop(x, Source::kConflict, Cause::kMixedPixel);
        matched_.remove(x);
      } else {
        cover_pmd(x);
      }
    });
  }

  // What the PMD says against matches that have rivals.
  void judge_unsure() noexcept {
    std::size_t end = 0;  // of what is judged together
    bool behind = false;
    bool outvoted = false;
    unsure_.each(row_.disparity.size(), [&](std::size_t x) noexcept {
      const DepthRange seen = pmd(x);
      const bool farther = row_.stereo.low[x] > seen.high;
      if (!farther && seen.low - row_.stereo.high[x] <= kMaxGuess) {
        return;
      }
      if (x >= end || farther != behind) {
        end = x + kJudgedTogether;
        behind = farther;
        outvoted = around_.outvotes_pmd(x, seen, behind);
      }
      if (outvoted) {
        drop(x, Source::kConflict, Cause::kContradiction);
      }
    });
  }

  // Matches of something near that reach beyond its left edge: across what only the left camera
  // sees, and nowhere else, are there pixels without a match.
  void cut_edges() noexcept {
    const std::size_t n = row_.disparity.size();
    std::size_t behind = 0;
    for (std::size_t x = matched_.next_without(0, n); x < n; x = matched_.next_without(behind, n)) {
      behind = matched_.next(x, n);
      if (x == 0 || behind == n) {
        continue;
      }
      const int step = row_.disparity[behind].raw - row_.disparity[x - 1].raw;
      if (step < kSurfaceStep ||
          step * kCutShare < row_.disparity[behind].raw - params_.infinity_raw) {
        continue;
      }
      const FattenedEdge edge(row_.picture, x - 1, behind);
      if (edge.end() <= matched_.next_without(behind, n)) {
        cut_edge(x - 1, behind, edge);
        behind = edge.end();
      }
    }
  }

  void cut_edge(std::size_t left_at, std::size_t right_at, const FattenedEdge& edge) noexcept {
    const MatchedSurface<Table> surface_behind = surface(row_.disparity[left_at].raw);
    for (std::size_t x = right_at; x < edge.end(); ++x) {
      if (!edge.is_behind(x)) {
        continue;
      }
      const DepthInterval interval = surface_behind.at(x);
      const DepthRange both = common({std::max<int>(interval.low, 1), interval.high}, pmd(x));
      if (both.empty() || middle_of(both.low, both.high) - out_.depth[x] > kMaxGuess) {
        continue;
      }
      const int near = published(x).low;
      put(x, both, Source::kResolved, Cause::kOccluded);
      widen(x, out_.depth[x] - near);
      if (edge_.has(x)) {
        cover_pmd(x);
      }
      matched_.remove(x);
    }
  }

  // Readings at edges of the PMD that no match around explains.
  void drop_wide_edges() noexcept {
    const std::size_t n = row_.disparity.size();
    edge_.intersect(open_, n);
    edge_.each(n, [this](std::size_t x) noexcept {
      if (out_.source[x] == Source::kPmd && out_.depth[x] - pmd(x).low > kMaxGuess) {
        drop(x, Source::kConflict, Cause::kMixedPixel);
      }
    });
  }

  bool publish(std::size_t x, const OpenRun& run, const MatchedSurface<Table>& where, Source source,
               Cause cause) noexcept {
    const DepthInterval interval = where.at(x);
    const DepthRange both = common({std::max<int>(interval.low, 1), interval.high}, pmd(x));
    if (both.empty()) {
      return false;
    }
    put(x, both, source, cause);
    open_.remove(x);
    if (edge_.has(x)) {
      if (may_be_nearer(x, run) ||
          (cause == Cause::kStereoAmbiguous && out_.depth[x] - pmd(x).low > kMaxVagueGuess)) {
        drop(x, Source::kConflict, Cause::kMixedPixel);
      } else {
        cover_pmd(x);
      }
    }
    return true;
  }

  // The pixels of a run that only the left camera sees.
  void resolve_shadow(const OpenRun& run) noexcept {
    if (!run.right.valid()) {
      return;
    }
    const int step = run.left.valid() ? run.right.raw - run.left.raw : run.right.raw;
    if (run.left.valid() && step < kSurfaceStep) {
      return;
    }
    // Whole pixels from the right neighbour, or from the left border where nothing is to the left.
    const int margin = params_.wide_pmd && run.left.valid() ? kWideShadowMargin : kShadowMargin;
    const int reach = (step + margin * Disparity::kOne) / Disparity::kOne;
    if (reach < 0) {
      return;
    }
    const std::size_t pixels = index(reach);
    std::size_t from = run.begin;
    std::size_t to = run.end;
    if (run.left.valid()) {
      from = std::max(from, run.right_at - std::min(run.right_at, pixels));
    } else {
      to = std::min(to, pixels + 1);
      from = std::max(from, run.right_at - std::min(run.right_at, std::size_t{kPullReach}));
    }
    const int sure = step / Disparity::kOne + kShadowMargin;
    const MatchedSurface<Table> behind = surface(run.left.valid() ? run.left.raw : run.right.raw);
    for (std::size_t x = from; x < to; ++x) {
      if (!publish(x, run, behind, Source::kResolved, Cause::kOccluded)) {
        continue;
      }
      if (!run.left.valid()) {
        pull(x, out_.depth[x] * run.to_right(x) / kPullWay);
      } else if (run.to_right(x) > sure && out_.source[x] == Source::kResolved) {
        cover_pmd(x);
      }
    }
  }

  // The pixels' own matches, which become neighbours of others.
  void confirm_weak(const OpenRun& run) noexcept {
    for (std::size_t x = weak_.next(run.begin, run.end); x < run.end;
         x = weak_.next(x + 1, run.end)) {
      if (open_.has(x) && publish(x, run, surface(row_.weak[x].raw), Source::kBoth, Cause::kNone) &&
          out_.source[x] == Source::kBoth) {
        cover_pmd(x);
        confirmed_.add(x);
      }
    }
  }

  // Between two matches of one surface.
  void resolve_gap(const OpenRun& run) noexcept {
    const int step = run.right.raw - run.left.raw;
    if (!run.left.valid() || !run.right.valid() || std::abs(step) >= kSurfaceStep) {
      return;
    }
    const int part = (1 << kPartBits) / static_cast<int>(run.right_at - run.left_at);
    for (std::size_t x = run.begin; x < run.end; ++x) {
      const int raw = run.left.raw + round_shift(step * (part * run.to_left(x)), kPartBits);
      if (publish(x, run, surface(raw), Source::kResolved, Cause::kStereoAmbiguous)) {
        pull(x, out_.depth[x] / kPullShare);
      }
    }
  }

  // Where the pair is there, and matches tell nothing: what the PMD read is better than the middle
  // of its interval, and than surfaces further away where there is a match on one side at most.
  void take_readings(const OpenRun& run) noexcept {
    const bool between = run.left.valid() && run.right.valid();
    for (std::size_t x = run.begin; x < run.end; ++x) {
      if (!open_.has(x) || out_.source[x] != Source::kPmd) {
        continue;
      }
      const DepthRange seen = pmd(x);
      const int depth = std::clamp<int>(row_.reading[x], seen.low, seen.high);
      out_.depth[x] = static_cast<QuarterMm>(depth);
      if (between || edge_.has(x) || depth - seen.low > kMaxGuess) {
        cover_pmd(x);
      } else {  // of one surface
        widen(x, (seen.high - seen.low + 1) / 2);
        out_.source[x] = Source::kResolved;
        out_.cause[x] = Cause::kStereoAmbiguous;
      }
    }
  }

  // Where the PMD says that there is an edge: the surface that is nearest in the picture, or the
  // other one.
  void resolve_edges(const OpenRun& run) noexcept {
    std::size_t x = edge_.next(run.begin, run.end);
    if (x == run.end) {
      return;
    }
    const MatchedSurface<Table> left = surface(run.left.raw, kMixedShare);
    const MatchedSurface<Table> right = surface(run.right.raw, kMixedShare);
    for (; x < run.end; x = edge_.next(x + 1, run.end)) {
      if (!open_.has(x)) {
        continue;
      }
      const bool has_left = run.left.valid() && run.to_left(x) <= params_.reach_px;
      const bool has_right = run.right.valid() && run.to_right(x) <= params_.reach_px;
      const bool left_first = has_left && (!has_right || run.to_left(x) <= run.to_right(x));
      const MatchedSurface<Table>& nearest = left_first ? left : right;
      const MatchedSurface<Table>& farthest = left_first ? right : left;
      const bool both = has_left && has_right;
      if ((has_left || has_right) &&
          !publish(x, run, nearest, Source::kResolved, Cause::kMixedPixel) && both) {
        publish(x, run, farthest, Source::kResolved, Cause::kMixedPixel);
      }
    }
  }

  const AmbiguityRow& row_;
  const AmbiguityParams& params_;
  const Table& table_;
  const Surroundings<Table> around_;
  PixelSet open_;       // that have yet to be resolved
  PixelSet matched_;    // whose match was published and stands for a surface
  PixelSet confirmed_;  // by their weak match
  PixelSet folded_;     // kConflict at first, and a range apart
  PixelSet weak_;       // with a weak match alone
  PixelSet edge_;       // where the PMD says that there is an edge
  PixelSet alone_;      // by their match and nothing else
  PixelSet vague_;      // by a match of high ratio, where the PMD says that there is an edge
  PixelSet unsure_;     // by the PMD against a match of high ratio
};

template <typename Table>
void resolve(const AmbiguityRow& row, const AmbiguityParams& params, const Table& table,
             const FusedRow& out) noexcept {
  const std::size_t n = row.disparity.size();
  STOF_CHECK(n <= std::size_t{kMaxImageWidth} && (row.weak.empty() || row.weak.size() == n));
  STOF_CHECK(row.stereo.low.size() == n && row.stereo.high.size() == n);
  STOF_CHECK(row.pmd.low.size() == n && row.pmd.high.size() == n && row.reading.size() == n);
  STOF_CHECK(row.support.ratio.size() == n && row.support.pmd_flags.size() == n);
  STOF_CHECK(out.depth.size() == n && out.width.size() == n && out.source.size() == n &&
             out.cause.size() == n);
  AmbiguityResolver(row, params, table, out).run();
}

}  // namespace

void resolve_ambiguities(const AmbiguityRow& row, const AmbiguityParams& params,
                         const DisparityTable& table, const FusedRow& out) noexcept {
  resolve(row, params, table, out);
}

void resolve_ambiguities(const AmbiguityRow& row, const AmbiguityParams& params,
                         const ColumnTables& tables, const FusedRow& out) noexcept {
  resolve(row, params, tables, out);
}

}  // namespace stof::dsp
