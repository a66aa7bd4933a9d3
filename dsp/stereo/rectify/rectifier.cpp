#include "dsp/stereo/rectify/rectifier.h"

#include <cstdint>
#include <span>

#include "dsp/base/check.h"
#include "dsp/calib/stereo/rectification.h"

namespace stof::dsp {
namespace {

// The column of the right picture that is nearest to the match.
std::int32_t match_of(std::int32_t x, Disparity disparity) noexcept {
  return x - round_shift<std::int32_t>(disparity.raw, Disparity::kFractionBits);
}

bool within(const RemapTable::Seen& seen, std::int32_t x) noexcept {
  return x >= seen.begin && x < seen.end;
}

const RawPair& raw_of(const StereoRig& rig) noexcept {
  STOF_CHECK(rig.raw.has_value());
  return *rig.raw;
}

}  // namespace

Rectifier::Rectifier(const StereoRig& rig, Arena& arena) noexcept
    : Rectifier(raw_of(rig), dsp::rectify(raw_of(rig)), arena) {}

Rectifier::Rectifier(const RawPair& pair, const Rectification& rectified, Arena& arena) noexcept
    : left_(arena.take_image<std::uint8_t>(rectified.left.width, rectified.left.height)),
      right_(arena.take_image<std::uint8_t>(rectified.left.width, rectified.left.height)),
      left_table_(SourceMap(pair.left, rectified.left_turn, rectified.left), arena),
      right_table_(SourceMap(pair.right, rectified.right_turn, rectified.right), arena) {}

void Rectifier::rectify(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                        Rows rows) noexcept {
  STOF_CHECK(same_size(left, left_) && same_size(right, right_));
  for (int y = rows.begin; y < rows.end; ++y) {
    left_table_.remap(left, y, left_.row(y));
    right_table_.remap(right, y, right_.row(y));
  }
}

void Rectifier::clear_border(Rows rows, ImageView<Disparity> disparity) const noexcept {
  STOF_CHECK(same_size(disparity, left_));
  for (int y = rows.begin; y < rows.end; ++y) {
    const RemapTable::Seen left = left_table_.seen(y);
    const RemapTable::Seen right = right_table_.seen(y);
    const std::span<Disparity> row = disparity.row(y);
    const auto width = static_cast<std::int32_t>(row.size());
    Disparity* const pixels = row.data();
    for (std::int32_t x = 0; x < width; ++x) {
      const bool keep = within(left, x) && within(right, match_of(x, pixels[x]));
      pixels[x] = keep ? pixels[x] : Disparity::none();
    }
    for (std::int32_t x = 0; x < width && (left.torn || right.torn); ++x) {
      if (pixels[x].valid() &&
          !(left_table_.inside(x, y) && right_table_.inside(match_of(x, pixels[x]), y))) {
        pixels[x] = Disparity::none();
      }
    }
  }
}

}  // namespace stof::dsp
