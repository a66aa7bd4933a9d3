#include "dsp/fusion/fuser.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>

#include "dsp/base/check.h"
#include "dsp/calib/column_tables.h"
#include "dsp/calib/disparity_table.h"
#include "dsp/fusion/column_interval.h"
#include "dsp/fusion/intersect.h"
#include "dsp/fusion/reproject.h"
#include "dsp/fusion/stereo_interval.h"

namespace stof::dsp {
namespace {

std::size_t pixels(int width, int height) noexcept {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

// All subpixel disparities of the candidates, half a candidate to either side, and none.
std::size_t table_size(int disparities) noexcept {
  return static_cast<std::size_t>((disparities + 1) * Disparity::kOne + 2);
}

// The same range of disparities for every column, two sigma further to either side.
std::size_t column_table_size(int width, int disparities, int sigma_raw) noexcept {
  return right_tangents(static_cast<std::size_t>(width), 0, (disparities + 1) * Disparity::kOne,
                        sigma_raw);
}

}  // namespace

struct Fuser::Tables {
  FusionParams params;
  bool converging;  // then columns count, else disparity does
  ColumnTables columns;
  DisparityTable disparity;
  Reprojector reprojector;
  PaintedView painted;
  std::span<QuarterMm> stereo_low;
  std::span<QuarterMm> stereo_high;
};

std::size_t Fuser::bytes_needed(int width, int height, int disparities, int pmd_width,
                                int pmd_height) noexcept {
  return Arena::bytes_for<Tables>(1) + Arena::bytes_for<DepthInterval>(table_size(disparities)) +
         Arena::bytes_for<std::int32_t>(static_cast<std::size_t>(width)) +
         Arena::bytes_for<std::int32_t>(column_table_size(width, disparities, kMaxStereoSigma)) +
         3 * Arena::bytes_for<QuarterMm>(pixels(width, height)) +
         Arena::bytes_for<std::uint8_t>(pixels(width, height)) +
         2 * Arena::bytes_for<QuarterMm>(static_cast<std::size_t>(width)) +
         Reprojector::bytes_needed(pmd_width, pmd_height);
}

Fuser::Fuser(const Calibration& calibration, const FusionParams& params, int min_disparity,
             int disparities, int width, int height, Arena& arena) noexcept {
  tables_ = std::construct_at(arena.take<Tables>(1).data());
  Tables& t = *tables_;
  t.params = params;
  const auto first =
      static_cast<std::int16_t>(std::max((min_disparity - 1) * Disparity::kOne, -32767));
  t.converging = calibration.stereo.converging.has_value();
  if (t.converging) {
    STOF_CHECK(params.stereo_sigma <= kMaxStereoSigma);
    const int last = std::min<int>(first + (disparities + 1) * Disparity::kOne, 32767);
    t.columns = make_column_tables(
        calibration.stereo, first, static_cast<std::int16_t>(last), params.stereo_sigma,
        params.max_range, arena.take<std::int32_t>(static_cast<std::size_t>(width)),
        arena.take<std::int32_t>(
            right_tangents(static_cast<std::size_t>(width), first, last, params.stereo_sigma)));
  } else {
    const std::span<DepthInterval> intervals = arena.take<DepthInterval>(table_size(disparities));
    t.disparity = {first, intervals};
    fill_disparity_table(calibration.stereo, first, params.stereo_sigma, params.max_range,
                         intervals);
  }
  t.painted.nearest = arena.take_image<QuarterMm>(width, height);
  t.painted.low = arena.take_image<QuarterMm>(width, height);
  t.painted.high = arena.take_image<QuarterMm>(width, height);
  t.painted.flags = arena.take_image<std::uint8_t>(width, height);
  t.stereo_low = arena.take<QuarterMm>(static_cast<std::size_t>(width));
  t.stereo_high = arena.take<QuarterMm>(static_cast<std::size_t>(width));
  t.reprojector = Reprojector(calibration, width, height, arena);
}

void Fuser::fuse(ImageView<const Disparity> disparity, const PmdMaps* pmd,
                 const DepthMap& out) noexcept {
  Tables& t = *tables_;
  STOF_CHECK(same_size(out.depth, t.painted.low) && same_size(out.width, out.depth) &&
             same_size(out.source, out.depth));
  STOF_CHECK(disparity.empty() || same_size(disparity, out.depth));
  const Rows all = out.depth.rows();
  if (pmd != nullptr) {
    t.reprojector.locate(*pmd);
  } else {
    t.reprojector.forget();
  }
  t.reprojector.paint(all, t.painted);
  for (int y = all.begin; y < all.end; ++y) {
    if (disparity.empty()) {
      std::ranges::fill(t.stereo_low, QuarterMm{0});
      std::ranges::fill(t.stereo_high, QuarterMm{0});
    } else if (t.converging) {
      best::column_interval(disparity.row(y), t.columns, t.stereo_low, t.stereo_high);
    } else {
      best::stereo_interval(disparity.row(y), t.disparity, t.stereo_low, t.stereo_high);
    }
    best::intersect({t.stereo_low, t.stereo_high}, {t.painted.low.row(y), t.painted.high.row(y)},
                    t.painted.flags.row(y), t.params.max_range, out.depth.row(y), out.width.row(y),
                    out.source.row(y));
  }
}

}  // namespace stof::dsp
