#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/calib/calibration.h"
#include "dsp/calib/pmd/ray_table.h"
#include "dsp/fusion/project/footprint.h"
#include "dsp/fusion/project/project.h"
#include "dsp/fusion/project/splat.h"
#include "dsp/pmd/converter.h"
#include "dsp/pmd/interval/interval.h"

namespace stof::dsp {

// Carries PMD pixels into the left view: X_s = R X_p + T and both camera models, radial distance
// to Z. A reading covers the pixels within (f_s / f_p) (Z_p / Z_s) / 2 + 0.6 px of its place; where
// the ends of its interval lie further apart than that, it is splatted at both ends too, because it
// may stand anywhere between. Where a reading lies is averaged along its surface once more
// (interval/average_pairs.h), wide pixels too, unless maps.sigma is empty: its interval stays what
// it is. Readings behind the camera and footprints outside the image are left out; an end behind
// the camera counts as 1/4 mm before it.
class Reprojector {
 public:
  Reprojector() noexcept = default;
  // left_width x left_height: stereo size, at most 32767 each. PMD size 0x0: never any footprint.
  Reprojector(const Calibration& calibration, int left_width, int left_height,
              Arena& arena) noexcept;

  // Computes the footprints of a frame, or forgets the last one's. maps of the calibration's size.
  // margin: by how much a surface may have come nearer or gone since; intervals are longer by it at
  // both ends.
  void locate(const PmdMaps& maps, QuarterMm margin = 0) noexcept;
  void forget() noexcept { count_ = 0; }
  std::span<const Footprint> footprints() const noexcept { return footprints_.first(count_); }

  // Writes these rows of all images. The result does not depend on how rows are split.
  void splat(Rows rows, const SplattedView& view) const noexcept;

 private:
  // Where a row's points lie: the readings or an end of their intervals.
  struct Points {
    std::span<std::int32_t> u;
    std::span<std::int32_t> v;
    std::span<QuarterMm> depth;
  };
  // The areas that a row's readings cover.
  struct Extents {
    std::span<std::int32_t> half_x;
    std::span<std::int32_t> half_y;
    std::span<std::int16_t> x_begin;
    std::span<std::int16_t> x_end;
    std::span<std::int16_t> y_begin;
    std::span<std::int16_t> y_end;
  };
  // The footprints of one row of the PMD camera, from `begin` on, lie in the rows y_begin .. y_end
  // - 1: what is asked for few rows of the left view need not look at all of them.
  struct Band {
    std::uint32_t begin;
    std::uint32_t count;
    std::int16_t y_begin;
    std::int16_t y_end;
  };
  static Points take_points(Arena& arena, int count) noexcept;
  static Extents take_extents(Arena& arena, int count) noexcept;
  // Where the readings of row y lie.
  std::span<const QuarterMm> average(const PmdMaps& maps, int y) noexcept;
  void locate_row(const PmdMaps& maps, int y, QuarterMm margin) noexcept;
  void add_row(std::span<const std::uint8_t> flags, QuarterMm margin) noexcept;
  Band band(std::size_t begin) const noexcept;

  int width_ = 0;
  int height_ = 0;
  int left_width_ = 0;
  int left_height_ = 0;
  FootprintScale scale_;
  Projection projection_;
  RayTable rays_;
  std::span<QuarterMm> distance_;  // of a row, averaged
  std::span<QuarterMm> sigma_;
  Points low_;
  Points centre_;
  Points high_;
  Extents extents_;
  std::span<Footprint> footprints_;
  std::span<Band> bands_;
  std::size_t count_ = 0;
};

}  // namespace stof::dsp
