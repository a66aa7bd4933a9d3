#include "dsp/stereo/rectifier.h"

#include <span>

#include "dsp/base/check.h"
#include "dsp/base/target.h"
#include "dsp/calib/rectification.h"
#include "dsp/stereo/rectify.h"

namespace stof::dsp {
namespace {

RemapTable take_table(Arena& arena, int width, int height) noexcept {
  return {.x = arena.take_image<std::uint16_t>(width, height),
          .y = arena.take_image<std::uint16_t>(width, height),
          .fraction_x = arena.take_image<std::uint8_t>(width, height),
          .fraction_y = arena.take_image<std::uint8_t>(width, height)};
}

bool inside(std::uint8_t mask) noexcept { return (mask & kPlaceInside) != 0; }

}  // namespace

std::size_t Rectifier::bytes_needed(int width, int height) noexcept {
  const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  return 4 * Arena::bytes_for<std::uint16_t>(pixels) + 6 * Arena::bytes_for<std::uint8_t>(pixels);
}

Rectifier::Rectifier(const StereoRig& rig, Arena& arena) noexcept {
  STOF_CHECK(rig.raw.has_value());
  const Rectification rectified = dsp::rectify(*rig.raw);
  const int width = rectified.left.width;
  const int height = rectified.left.height;
  left_ = arena.take_image<std::uint8_t>(width, height);
  right_ = arena.take_image<std::uint8_t>(width, height);
  left_table_ = take_table(arena, width, height);
  right_table_ = take_table(arena, width, height);
  fill_remap_table(SourceMap(rig.raw->left, rectified.left_turn, rectified.left), left_table_);
  fill_remap_table(SourceMap(rig.raw->right, rectified.right_turn, rectified.right), right_table_);
}

void Rectifier::rectify(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                        Rows rows) noexcept {
  STOF_CHECK(same_size(left, left_) && same_size(right, right_));
  for (int y = rows.begin; y < rows.end; ++y) {
    best::remap_row(left, left_table_.row(y), left_.row(y));
    best::remap_row(right, right_table_.row(y), right_.row(y));
  }
}

void Rectifier::clear_border(Rows rows, ImageView<Disparity> disparity) const noexcept {
  STOF_CHECK(same_size(disparity, left_));
  for (int y = rows.begin; y < rows.end; ++y) {
    const std::span<const std::uint8_t> left = left_mask().row(y);
    const std::span<const std::uint8_t> right = right_mask().row(y);
    const std::span<Disparity> row = disparity.row(y);
    for (std::size_t x = 0; x < row.size(); ++x) {
      const int shift = round_shift<int>(row[x].raw, Disparity::kFractionBits);
      const std::size_t match = x - static_cast<std::size_t>(shift);  // wraps where it is negative
      if (!inside(left[x]) || match >= right.size() || !inside(right[match])) {
        row[x] = Disparity::none();
      }
    }
  }
}

}  // namespace stof::dsp
