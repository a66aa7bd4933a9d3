#include "dsp/fusion/fuser.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <span>

#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "dsp/calib/stereo/interval_tables.h"
#include "dsp/fusion/interval/column_interval.h"
#include "dsp/fusion/interval/intersect.h"
#include "dsp/fusion/interval/late_intervals.h"
#include "dsp/fusion/interval/stereo_interval.h"
#include "dsp/fusion/project/reproject.h"
#include "dsp/fusion/resolve/ambiguity_resolver.h"
#include "dsp/fusion/resolve/hole_filler.h"
#include "dsp/fusion/resolve/match_evidence.h"
#include "dsp/stereo/match_params.h"

namespace stof::dsp {
namespace {

constexpr int kStripeRows = 64;

std::int16_t infinity_of(const StereoRig& rig) noexcept {
  constexpr double kFarthest = 16384;
  return static_cast<std::int16_t>(
      std::clamp(std::round(-rig.doff_px * Disparity::kOne), -kFarthest, kFarthest));
}

// Three PMD pixels in pixels of the left view: what an interval of 3x3 readings can come from.
int reach_of(const Calibration& calibration) noexcept {
  const double ratio = calibration.stereo.left.fx / calibration.pmd.lens.fx;
  return static_cast<int>(std::clamp(std::ceil(3 * ratio), 2.0, double{kMaxImageWidth}));
}

// Unambiguous range in quarter mm; 0 where it does not fit.
QuarterMm range_of(const PmdSensor& sensor) noexcept {
  const double range =
      kQuarterMmPerMetre * kLightMetresPerSecond / (2.0 * sensor.frequency.modulation.value);
  return range < kMaxQuarterMm ? static_cast<QuarterMm>(std::lround(range)) : QuarterMm{0};
}

// By how much a surface that the PMD saw may lie nearer or further for the pair.
QuarterMm margin_of(const PmdMaps& pmd, std::int32_t max_speed_mm_s,
                    std::int32_t pmd_lag_us) noexcept {
  if (!pmd.moved) {
    return 0;
  }
  constexpr std::int64_t kUsPerS = 1'000'000;
  constexpr std::int64_t kQuarterMmPerMm = 4;
  const std::int64_t lag = std::abs(std::int64_t{pmd_lag_us});
  const std::int64_t far = (kQuarterMmPerMm * max_speed_mm_s * lag + kUsPerS - 1) / kUsPerS;
  return static_cast<QuarterMm>(std::min<std::int64_t>(far, kMaxQuarterMm));
}

}  // namespace

// The pair's intervals of one row.
struct Fuser::StereoRow : LateIntervals {
  static constexpr std::size_t kPart = 64;  // pixels that are told at once
  static_assert(kMaxImageWidth <= kPart * 64, "a bit for each part");

  const Tables* tables;
  std::span<const Disparity> disparity;
  std::span<const std::uint8_t> ratio;  // may be empty
  std::span<std::uint8_t> half;
  std::span<QuarterMm> low;
  std::span<QuarterMm> high;
  std::uint64_t told;  // parts
};

// Rows of one thread.
struct Fuser::Scratch {
  std::span<QuarterMm> stereo_low;  // where the Fuser does not keep it
  std::span<QuarterMm> stereo_high;
  std::span<std::uint8_t> half;
  std::span<Cause> cause;  // where the caller wants none
  std::span<QuarterMm> reading;
  StereoRow stereo;
};

struct Fuser::Tables {
  FusionParams params;
  AmbiguityParams ambiguity;
  IntervalTables intervals;
  MatchEvidence evidence;
  Reprojector reprojector;
  SplattedView splatted;
  HoleFiller filler;
  std::span<std::uint8_t> ratio;  // of matches without one
  std::span<Disparity> nothing;   // a row without stereo
  std::span<Scratch> scratch;     // of each thread
};

Fuser::Fuser(const Calibration& calibration, const FusionParams& params, int min_disparity,
             int disparities, int width, int height, Arena& arena, int threads) noexcept {
  STOF_CHECK(threads >= 1);
  STOF_CHECK(params.max_speed_mm_s >= 0 && params.max_speed_mm_s <= kMaxSpeedMmS);
  STOF_CHECK(params.stereo_sigma >= 0 && params.stereo_sigma <= kMaxStereoSigma);
  const std::size_t row = index(width);
  Tables t{.params = params,
           .ambiguity = {.infinity_raw = infinity_of(calibration.stereo),
                         .max_range = params.max_range,
                         .doubt_px = params.trust.doubt_px},
           .intervals = {},
           .evidence = MatchEvidence(calibration, infinity_of(calibration.stereo)),
           .reprojector = {},
           .splatted = {},
           .filler = HoleFiller(width, height, params.max_range, arena),
           .ratio = {},
           .nothing = {},
           .scratch = {}};
  if (calibration.pmd.lens.width > 0) {
    t.ambiguity.pmd_range = range_of(calibration.pmd);
    t.ambiguity.reach_px = reach_of(calibration);
    t.ambiguity.wide_pmd = !is_fine(calibration.pmd.lens);
  }
  t.intervals = make_interval_tables(calibration.stereo, min_disparity, disparities, width,
                                     params.max_range, arena);
  t.splatted.low = arena.take_passing_image<QuarterMm>(width, height);
  t.splatted.high = arena.take_passing_image<QuarterMm>(width, height);
  t.splatted.flags = arena.take_passing_image<std::uint8_t>(width, height);
  t.ratio = arena.take_filled(row, std::uint8_t{0});
  t.nothing = arena.take_filled(row, Disparity::none());
  t.scratch = arena.take<Scratch>(index(threads));
  for (Scratch& scratch : t.scratch) {
    const Scratch rows{arena.take_passing<QuarterMm>(row),    arena.take_passing<QuarterMm>(row),
                       arena.take_passing<std::uint8_t>(row), arena.take_passing<Cause>(row),
                       arena.take_passing<QuarterMm>(row),    {}};
    if (!arena.is_measuring()) {
      scratch = rows;
    }
  }
  t.reprojector = Reprojector(calibration, width, height, arena);
  tables_ = arena.put(t);
}

// Fills pixels begin .. end - 1. Columns of converging axes are looked up by their numbers: there,
// all of a row.
void Fuser::tell(const StereoRow& row, std::size_t begin, std::size_t end) noexcept {
  const Tables& t = *row.tables;
  const std::size_t count = end - begin;
  const std::span<const Disparity> disparity = row.disparity.subspan(begin, count);
  const std::span<std::uint8_t> half = row.half.subspan(begin, count);
  if (row.ratio.empty()) {
    std::ranges::fill(half, static_cast<std::uint8_t>(2 * t.params.stereo_sigma));
  } else {
    best::disparity_sigma(disparity, row.ratio.subspan(begin, count), t.params.trust.sigma_by_ratio,
                          t.ambiguity.infinity_raw, half);
  }
  const std::span<QuarterMm> low = row.low.subspan(begin, count);
  const std::span<QuarterMm> high = row.high.subspan(begin, count);
  if (t.intervals.converging) {
    best::column_interval(disparity, half, t.intervals.columns, low, high);
  } else {
    best::stereo_interval(disparity, half, t.intervals.disparity, low, high);
  }
}

void Fuser::tell_parts(LateIntervals& self, std::size_t begin, std::size_t end) noexcept {
  StereoRow& row = static_cast<StereoRow&>(self);
  const std::size_t n = row.disparity.size();
  if (row.tables->intervals.converging) {
    begin = 0;
    end = n;
  }
  for (std::size_t part = begin / StereoRow::kPart; part * StereoRow::kPart < end; ++part) {
    const std::uint64_t bit = std::uint64_t{1} << part;
    if ((row.told & bit) != 0) {
      continue;
    }
    if (row.tables->intervals.converging) {
      tell(row, 0, n);
      row.told = ~std::uint64_t{0};
      return;
    }
    const std::size_t first = part * StereoRow::kPart;
    tell(row, first, std::min(first + StereoRow::kPart, n));
    row.told |= bit;
  }
}

// Of the thread whose scratch it is.
Fuser::StereoRow Fuser::stereo_row(const StereoMaps& stereo, int y,
                                   const Scratch& scratch) const noexcept {
  const Tables& t = *tables_;
  StereoRow row{};
  row.tell = &Fuser::tell_parts;
  row.tables = tables_;
  row.disparity =
      stereo.disparity.empty() ? std::span<const Disparity>(t.nothing) : stereo.disparity.row(y);
  if (!stereo.ratio.empty()) {
    row.ratio = stereo.ratio.row(y);
  }
  row.half = scratch.half;
  row.low = scratch.stereo_low;
  row.high = scratch.stereo_high;
  return row;
}

void Fuser::fuse_row(const StereoMaps& stereo, int y, const Scratch& scratch,
                     const DepthMap& out) noexcept {
  Tables& t = *tables_;
  AmbiguityRow row{.disparity = t.nothing,
                   .weak = {},
                   .stereo = {scratch.stereo_low, scratch.stereo_high},
                   .pmd = {t.splatted.low.row(y), t.splatted.high.row(y)},
                   .reading = scratch.reading,
                   .support = {t.ratio, t.splatted.flags.row(y)},
                   .view = stereo.disparity,
                   .y = y,
                   .evidence = &t.evidence};
  if (!stereo.disparity.empty()) {
    row.disparity = stereo.disparity.row(y);
  }
  std::ranges::copy(out.depth.row(y), scratch.reading.begin());  // what fuse_rows() splatted
  tell(stereo_row(stereo, y, scratch), 0, row.disparity.size());
  if (!stereo.weak.empty()) {
    row.weak = stereo.weak.row(y);
  }
  if (!stereo.ratio.empty()) {
    row.support.ratio = stereo.ratio.row(y);
  }
  if (!stereo.picture.empty()) {
    row.picture = stereo.picture.row(y);
    row.whole = stereo.picture;
  }
  const FusedRow fused{out.depth.row(y), out.width.row(y), out.source.row(y),
                       out.cause.empty() ? scratch.cause : out.cause.row(y)};
  best::intersect(row.stereo, row.pmd, row.support, t.params.max_range, fused);
  if (t.intervals.converging) {
    resolve_ambiguities(row, t.ambiguity, t.intervals.columns, fused);
  } else {
    resolve_ambiguities(row, t.ambiguity, t.intervals.disparity, fused);
  }
}

void Fuser::prepare(const PmdMaps* pmd, std::int32_t pmd_lag_us) noexcept {
  tables_->evidence.look_at(pmd);
  if (pmd != nullptr) {
    tables_->reprojector.locate(*pmd, margin_of(*pmd, tables_->params.max_speed_mm_s, pmd_lag_us));
  } else {
    tables_->reprojector.forget();
  }
}

void Fuser::fuse_rows(const StereoMaps& stereo, Rows rows, int thread,
                      const DepthMap& out) noexcept {
  const Tables& t = *tables_;
  STOF_CHECK(same_size(out.depth, t.splatted.low) && same_size(out.width, out.depth) &&
             same_size(out.source, out.depth) &&
             (out.cause.empty() || same_size(out.cause, out.depth)));
  STOF_CHECK(stereo.disparity.empty() || same_size(stereo.disparity, out.depth));
  STOF_CHECK(stereo.ratio.empty() || same_size(stereo.ratio, out.depth));
  STOF_CHECK(stereo.weak.empty() || same_size(stereo.weak, out.depth));
  STOF_CHECK(stereo.picture.empty() || same_size(stereo.picture, out.depth));
  STOF_CHECK(rows.begin >= 0 && rows.end <= out.depth.height());
  const Scratch& scratch = t.scratch[index(thread)];
  // Each row of the z-buffer is of no use once it is fused: depth is written over it.
  SplattedView splatted = t.splatted;
  splatted.nearest = out.depth;
  // In stripes, so that what was splatted is still near when it is fused.
  for (int y = rows.begin; y < rows.end; y += kStripeRows) {
    const Rows some{y, std::min(y + kStripeRows, rows.end)};
    t.reprojector.splat(some, splatted);
    for (int row = some.begin; row < some.end; ++row) {
      fuse_row(stereo, row, scratch, out);
    }
  }
}

SensorIntervals Fuser::intervals(const StereoMaps& stereo, int y, int thread) noexcept {
  const Tables& t = *tables_;
  Scratch& scratch = t.scratch[index(thread)];
  scratch.stereo = stereo_row(stereo, y, scratch);
  return {.stereo = {scratch.stereo_low, scratch.stereo_high},
          .pmd = {t.splatted.low.row(y), t.splatted.high.row(y)},
          .late = &scratch.stereo};
}

bool Fuser::fills_holes(const StereoMaps& stereo, const DepthMap& out) const noexcept {
  return tables_->evidence.judges() && !stereo.disparity.empty() && !out.cause.empty();
}

Rows Fuser::cell_rows() const noexcept { return tables_->filler.cell_rows(); }

Rows Fuser::map_rows(Rows cells) const noexcept { return tables_->filler.map_rows(cells); }

void Fuser::gather_surfaces(Rows cells, const DepthMap& out) noexcept {
  tables_->filler.gather(cells, out);
}

void Fuser::fill_holes(const StereoMaps& stereo, Rows cells, const DepthMap& out) noexcept {
  const Tables& t = *tables_;
  t.filler.fill(cells, {stereo.disparity, t.splatted.low, t.splatted.high}, t.evidence, out);
}

void Fuser::fuse(const StereoMaps& stereo, const PmdMaps* pmd, const DepthMap& out) noexcept {
  prepare(pmd);
  fuse_rows(stereo, out.depth.rows(), 0, out);
  if (fills_holes(stereo, out)) {
    gather_surfaces(cell_rows(), out);
    fill_holes(stereo, cell_rows(), out);
  }
}

}  // namespace stof::dsp
