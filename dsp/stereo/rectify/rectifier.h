#pragma once

#include <cstddef>
#include <cstdint>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/calib/calibration.h"
#include "dsp/calib/stereo/remap_table.h"

namespace stof::dsp {

// Turns the raw pictures of a pair into rectified ones of the same size, through tables built once
// from the calibration. Holds tables (0.4 bytes a pixel) and both results, allocates nothing.
class Rectifier {
 public:
  // rig: complete(), with rig.raw.
  Rectifier(const StereoRig& rig, Arena& arena) noexcept;

  // Writes these rows of left() and right(). left, right: the calibration's size. The result of a
  // row does not depend on how rows are split.
  void rectify(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
               Rows rows) noexcept;

  // The rectified pictures. Pixels that their camera did not see repeat the raw picture's border.
  ImageView<const std::uint8_t> left() const noexcept { return left_; }
  ImageView<const std::uint8_t> right() const noexcept { return right_; }

  // Which pixels the cameras saw, the same for all frames, and where they saw them.
  const RemapTable& left_table() const noexcept { return left_table_; }
  const RemapTable& right_table() const noexcept { return right_table_; }

  // Drops the disparities of pixels that the left camera did not see, and those whose match, to
  // the nearest pixel, the right one did not see or lies outside of its picture.
  void clear_border(Rows rows, ImageView<Disparity> disparity) const noexcept;

 private:
  Rectifier(const RawPair& pair, const Rectification& rectified, Arena& arena) noexcept;

  ImageView<std::uint8_t> left_;
  ImageView<std::uint8_t> right_;
  RemapTable left_table_;
  RemapTable right_table_;
};

}  // namespace stof::dsp
