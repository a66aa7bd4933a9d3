#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/calib/calibration.h"
#include "dsp/fusion/paint.h"
#include "dsp/fusion/project.h"
#include "dsp/pmd/converter.h"

namespace stof::dsp {

// What a PMD pixel covers in the left view: columns x_begin .. x_end - 1, rows y_begin .. y_end -
// 1, inside the image and not empty. depth: Z of its reading, quarter mm.
struct Footprint {
  std::int16_t x_begin;
  std::int16_t x_end;
  std::int16_t y_begin;
  std::int16_t y_end;
  QuarterMm depth;
  Paint paint;
};

// PMD intervals in the left view. nearest is the z-buffer; low = kNothingPainted, high = 0 and
// flags = 0 where no footprint lies. All images have the stereo size.
struct PaintedView {
  ImageView<QuarterMm> nearest;
  ImageView<QuarterMm> low;
  ImageView<QuarterMm> high;
  ImageView<std::uint8_t> flags;  // of all footprints that are visible there, united
};

// Carries PMD pixels into the left view: X_s = R X_p + T and both camera models, radial distance
// to Z. A reading covers the pixels within (f_s / f_p) (Z_p / Z_s) / 2 + 0.6 px of its place; where
// the ends of its interval lie further apart than that, it is painted at both ends too, because it
// may stand anywhere between. Readings behind the camera and footprints outside the image are left
// out; an end behind the camera counts as 1/4 mm before it.
class Reprojector {
 public:
  static std::size_t bytes_needed(int pmd_width, int pmd_height) noexcept;

  Reprojector() noexcept = default;
  // left_width x left_height: stereo size, at most 32767 each. PMD size 0x0: never any footprint.
  Reprojector(const Calibration& calibration, int left_width, int left_height,
              Arena& arena) noexcept;

  // Computes the footprints of a frame, or forgets the last one's. maps of the calibration's size.
  void locate(const PmdMaps& maps) noexcept;
  void forget() noexcept { count_ = 0; }
  std::span<const Footprint> footprints() const noexcept { return footprints_.first(count_); }

  // Writes these rows of all images. The result does not depend on how rows are split.
  void paint(Rows rows, const PaintedView& view) const noexcept;

 private:
  // Where a row's points lie; which end of the interval, or the reading.
  struct Points {
    std::span<std::int32_t> u;
    std::span<std::int32_t> v;
    std::span<QuarterMm> depth;
  };
  static Points take_points(Arena& arena, int count) noexcept;
  void locate_row(const PmdMaps& maps, int y) noexcept;
  void locate_pixel(std::size_t i, QuarterMm distance, std::int16_t forward,
                    std::uint8_t flags) noexcept;
  void add(std::int32_t u, std::int32_t v, int half_x, int half_y, QuarterMm depth,
           const Paint& paint) noexcept;

  int width_ = 0;
  int height_ = 0;
  int left_width_ = 0;
  int left_height_ = 0;
  float half_x_ = 0;  // f_s / f_p / 2 in 1/16 px, for a Q15 ray
  float half_y_ = 0;
  Projection projection_;
  std::span<std::int16_t> ray_x_;
  std::span<std::int16_t> ray_y_;
  std::span<std::int16_t> ray_z_;
  std::span<std::int16_t> forward_;
  Points low_;
  Points centre_;
  Points high_;
  std::span<Footprint> footprints_;
  std::size_t count_ = 0;
};

}  // namespace stof::dsp
