#include "dsp/stereo/rectify/rectify.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "dsp/base/check.h"
#include "dsp/base/mutation.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {
namespace {

constexpr int kLanes = 8;
constexpr int kWindow = 16;  // pixels of a source row that are looked at together
constexpr int kMostRows = 6;

using Bends = std::array<std::int16_t, kPatchSide>;
constexpr Bends table_of(int (*value)(int)) noexcept {
  Bends table{};
  for (int k = 0; k < kPatchSide; ++k) {
    table[static_cast<std::size_t>(k)] = static_cast<std::int16_t>(value(k));
  }
  return table;
}
constexpr Bends kBend = table_of([](int k) noexcept { return patch_bend(k); });
constexpr Bends kTwist = table_of([](int k) noexcept { return patch_twist(k); });
constexpr std::array<std::int32_t, 4> kFirst{0, 1, 2, 3};
constexpr std::array<std::int32_t, 4> kBias{0, 0, kPatchBias, kPatchBias};

// One axis of a patch's line: A, B, C, D.
int32x4_t numbers_of(const PlacePatch& patch, std::size_t axis, float t) noexcept {
  const auto power = [&](std::size_t i) noexcept { return vld1q_f32(&patch.powers[i][4 * axis]); };
  float32x4_t sum = vaddq_f32(power(0), vmulq_n_f32(power(1), t));
  sum = vaddq_f32(sum, vmulq_n_f32(power(2), t * t));
  sum = vaddq_f32(sum, vmulq_n_f32(power(3), t * t * t));
  return vsubq_s32(vcvtq_s32_f32(sum), vld1q_s32(kBias.data()));
}

// Walks along a line of a patch on one axis, eight pixels a step.
class Walk {
 public:
  Walk(const PlacePatch& patch, std::size_t axis, float t) noexcept
      : low_(vdupq_n_s16(patch.low[axis])), high_(vdupq_n_s16(patch.high[axis])) {
    const int32x4_t numbers = numbers_of(patch, axis, t);
    const int32x4_t slope = vdupq_laneq_s32(numbers, 1);
    curve_ = vmovn_s32(numbers);
    straight_ = vmlaq_s32(vdupq_laneq_s32(numbers, 0), slope, vld1q_s32(kFirst.data()));
    four_ = vshlq_n_s32(slope, 2);
  }

  // Steps of 1/128 px from the patch's corner for pixels k .. k + 7.
  int16x8_t next(int k) noexcept {
    const int16x8_t bend = vld1q_s16(&kBend[static_cast<std::size_t>(k)]);
    const int16x8_t twist = vld1q_s16(&kTwist[static_cast<std::size_t>(k)]);
    const int32x4_t middle = vaddq_s32(straight_, four_);
    int32x4_t first = vmlal_lane_s16(straight_, vget_low_s16(bend), curve_, 2);
    int32x4_t second = vmlal_lane_s16(middle, vget_high_s16(bend), curve_, 2);
    first = vmlal_lane_s16(first, vget_low_s16(twist), curve_, 3);
    second = vmlal_lane_s16(second, vget_high_s16(twist), curve_, 3);
    straight_ = vaddq_s32(middle, four_);
    const int16x8_t steps = vuzp2q_s16(vreinterpretq_s16_s32(first), vreinterpretq_s16_s32(second));
    return vminq_s16(vmaxq_s16(steps, low_), high_);
  }

 private:
  int16x8_t low_, high_;
  int16x4_t curve_;
  int32x4_t straight_, four_;
};
static_assert(kPatchFractionBits == 16);  // high halves are whole steps

// Eight places: whole columns and rows from the patch's corner, fractions.
struct Eight {
  int16x8_t x, y;
  int16x8_t fraction_x, fraction_y;
};

Eight split(int16x8_t x, int16x8_t y) noexcept {
  const int16x8_t below_one = vdupq_n_s16(kPlaceOne - 1);
  return {.x = vshrq_n_s16(x, kPlaceFractionBits),
          .y = vshrq_n_s16(y, kPlaceFractionBits),
          .fraction_x = vandq_s16(x, below_one),
          .fraction_y = vandq_s16(y, below_one)};
}

// Lower halves of the vectors: left neighbours; upper halves: right ones.
uint8x8_t mix_rows(uint8x16_t upper, uint8x16_t lower, const Eight& places) noexcept {
  const uint8x8_t right = vmovn_u16(vreinterpretq_u16_s16(places.fraction_x));
  const uint8x8_t left = vsub_u8(vdup_n_u8(kPlaceOne), right);
  const auto columns = [&](uint8x16_t row) noexcept {
    return vreinterpretq_s16_u16(
        vmlal_u8(vmull_u8(vget_low_u8(row), left), vget_high_u8(row), right));
  };
  const int16x8_t above = columns(upper);
  // As Q15: a doubling multiplication that keeps the rounded high half divides by 128.
  const int16x8_t mixed = vaddq_s16(above, simd::scaled_product(vsubq_s16(columns(lower), above),
                                                                vshlq_n_s16(places.fraction_y, 8)));
  return vqrshrun_n_s16(mixed, kPlaceFractionBits);
}

// Places that lie too far from each other: pixel by pixel.
[[gnu::noinline]] void mix_apart(const ImageView<const std::uint8_t>& source,
                                 const PlacePatch& patch, const Eight& places,
                                 std::uint8_t* out) noexcept {
  std::array<std::array<std::int16_t, kLanes>, 4> lanes{};
  vst1q_s16(lanes[0].data(), places.x);
  vst1q_s16(lanes[1].data(), places.y);
  unmutate(lanes[0].data());
  unmutate(lanes[1].data());
  vst1q_s16(lanes[2].data(), places.fraction_x);
  vst1q_s16(lanes[3].data(), places.fraction_y);
  for (std::size_t k = 0; k < kLanes; ++k) {
    out[k] = mix(source, {.x = static_cast<std::uint16_t>(patch.x + lanes[0][k]),
                          .y = static_cast<std::uint16_t>(patch.y + lanes[1][k]),
                          .fraction_x = static_cast<std::uint8_t>(lanes[2][k]),
                          .fraction_y = static_cast<std::uint8_t>(lanes[3][k])});
  }
  mutate(out);
}

// A window of each row that eight pixels lie in: of 16 bytes some are taken by a table look-up;
// NEON has no gather.
struct Window {
  const std::uint8_t* first;
  std::ptrdiff_t stride;
  uint8x16_t index;

  uint8x16_t row(int y) const noexcept {
    return simd::look_up(vld1q_u8(first + y * stride), index);
  }
};

// Eight pixels in rows 0 .. `last` of the window, whose row `below` is the source's last.
uint8x8_t mix_steep(const Window& window, uint8x16_t line, int last, int below,
                    const Eight& places) noexcept {
  uint8x16_t next = window.row(1);
  uint8x16_t upper = window.row(0);
  uint8x16_t lower = next;
  for (int y = 1; y <= last; ++y) {
    const uint8x16_t here = vceqq_u8(line, vdupq_n_u8(static_cast<std::uint8_t>(y)));
    upper = vbslq_u8(here, next, upper);
    next = window.row(std::min(y + 1, below));
    lower = vbslq_u8(here, next, lower);
  }
  return mix_rows(upper, lower, places);
}

// The source as seen from a patch's corner.
struct Source {
  const std::uint8_t* corner;
  std::ptrdiff_t stride;
  int most_left;  // of a window
  int most_top;   // of three rows
};

// Eight pixels, which mostly lie in few rows and near to each other. Whether they do; else nothing
// is written.
bool mix_eight(const Source& source, const Eight& places, std::uint8_t* out) noexcept {
  const int y_first = vgetq_lane_s16(places.y, 0);
  const int y_last = vgetq_lane_s16(places.y, kLanes - 1);
  const int left = std::min<int>(
      {vgetq_lane_s16(places.x, 0), vgetq_lane_s16(places.x, kLanes - 1), source.most_left});
  const int top = std::min({y_first, y_last, source.most_top});
  const int last = std::max(1, std::max(y_first, y_last) - top);
  const uint16x8_t column =
      vreinterpretq_u16_s16(vsubq_s16(places.x, vdupq_n_s16(static_cast<std::int16_t>(left))));
  const uint16x8_t row =
      vreinterpretq_u16_s16(vsubq_s16(places.y, vdupq_n_s16(static_cast<std::int16_t>(top))));
  const uint16x8_t outside =
      vorrq_u16(vcgtq_u16(column, vdupq_n_u16(kWindow - 2)),
                vcgtq_u16(row, vdupq_n_u16(static_cast<std::uint16_t>(last))));
  if (last > kMostRows || vget_lane_u64(vreinterpret_u64_u8(vmovn_u16(outside)), 0) != 0) {
    return false;
  }
  const uint8x8_t at = vmovn_u16(column);
  const Window window{.first = source.corner + top * source.stride + left,
                      .stride = source.stride,
                      .index = vcombine_u8(at, vadd_u8(at, vdup_n_u8(1)))};
  const uint8x8_t line = vmovn_u16(row);
  const uint8x16_t lines = vcombine_u8(line, line);
  if (last > 1) {
    vst1_u8(out, mix_steep(window, lines, last, source.most_top + 2 - top, places));
    return true;
  }
  const uint8x16_t here = vtstq_u8(lines, lines);
  const uint8x16_t middle = window.row(1);
  vst1_u8(out, mix_rows(vbslq_u8(here, middle, window.row(0)),
                        vbslq_u8(here, window.row(2), middle), places));
  return true;
}

// All 32 pixels of a patch's line.
void remap_patch(const ImageView<const std::uint8_t>& image, const PlacePatch& patch, float t,
                 std::uint8_t* out) noexcept {
  const Source source{.corner = image.data() + patch.y * image.stride() + patch.x,
                      .stride = image.stride(),
                      .most_left = image.width() - kWindow - patch.x,
                      .most_top = image.height() - 3 - patch.y};
  Walk x(patch, 0, t);
  Walk y(patch, 1, t);
  for (int k = 0; k < kPatchSide; k += kLanes) {
    const int16x8_t along = x.next(k);
    const Eight places = split(along, y.next(k));
    if (!mix_eight(source, places, out + k)) {
      mix_apart(image, patch, places, out + k);
    }
  }
}

}  // namespace

void remap_row(ImageView<const std::uint8_t> source, std::span<const PlacePatch> patches, int line,
               std::span<std::uint8_t> out) noexcept {
  STOF_CHECK(out.size() <= patches.size() * kPatchSide && line >= 0 && line < kPatchSide);
  if (source.width() < kWindow || source.height() < 3) {
    ref::remap_row(source, patches, line, out);
    return;
  }
  const float t = static_cast<float>(2 * line - (kPatchSide - 1)) / kPatchSide;
  for (const PlacePatch& patch : patches) {
    const std::span<std::uint8_t> part = out.first(std::min<std::size_t>(out.size(), kPatchSide));
    out = out.subspan(part.size());
    if (!patch.serves) {
      continue;
    }
    if (part.size() == kPatchSide) {
      remap_patch(source, patch, t, part.data());
    } else {
      std::array<std::uint8_t, kPatchSide> whole{};
      remap_patch(source, patch, t, whole.data());
      std::copy_n(whole.begin(), part.size(), part.begin());
    }
  }
}

}  // namespace stof::dsp::neon
