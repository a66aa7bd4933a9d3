#include "dsp/fusion/project/splat.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {
namespace {

constexpr int kLanes = 8;

// What a footprint says, in all lanes of a vector or some: where it does not, low is the largest
// number, high and flags are 0.
struct Lanes {
  uint16x8_t visible;
  uint16x8_t low;
  uint16x8_t high;
  uint16x8_t flags;
};

Lanes lanes_of(const FootprintValue& value, uint16x8_t inside) noexcept {
  return {vdupq_n_u16(value.visible), vornq_u16(vdupq_n_u16(value.low), inside),
          vandq_u16(vdupq_n_u16(value.high), inside), vandq_u16(vdupq_n_u16(value.flags), inside)};
}

void unite(const Lanes& lanes, const QuarterMm* nearest, QuarterMm* low, QuarterMm* high,
           std::uint8_t* flags) noexcept {
  const uint16x8_t seen = vcgeq_u16(vld1q_u16(nearest), lanes.visible);
  // Where another surface hides this one: low becomes the largest number, high the smallest.
  const uint16x8_t from = vornq_u16(lanes.low, seen);
  const uint16x8_t to = vandq_u16(lanes.high, seen);
  vst1q_u16(low, vminq_u16(vld1q_u16(low), from));
  vst1q_u16(high, vmaxq_u16(vld1q_u16(high), to));
  const uint16x8_t marks = vandq_u16(lanes.flags, seen);
  vst1_u8(flags, vmovn_u16(vorrq_u16(vmovl_u8(vld1_u8(flags)), marks)));
}

// Whole vectors that cover the columns of a footprint and lie in the image, the last of them at
// `last`. Those of a wide footprint overlap rather than leave it, which changes nothing; the single
// one of a narrow footprint leaves it, so only the lanes `inside` may change.
struct Columns {
  int first;
  int last;
  int vectors;
  uint16x8_t inside;
};

uint16x8_t all_lanes(int value) noexcept { return vdupq_n_u16(static_cast<std::uint16_t>(value)); }

Columns columns(const Footprint& f, int width) noexcept {
  static constexpr std::array<std::uint16_t, kLanes> kLane{0, 1, 2, 3, 4, 5, 6, 7};
  const int count = f.x_end - f.x_begin;
  if (count >= kLanes) {
    return {f.x_begin, f.x_end - kLanes, (count + kLanes - 1) / kLanes, all_lanes(0xFFFF)};
  }
  const int first = std::min<int>(f.x_begin, width - kLanes);
  const uint16x8_t column = vsubq_u16(vld1q_u16(kLane.data()), all_lanes(f.x_begin - first));
  return {first, first, 1, vcltq_u16(column, all_lanes(count))};
}

Rows common(const Footprint& footprint, Rows rows) noexcept {
  return {std::max<int>(footprint.y_begin, rows.begin), std::min<int>(footprint.y_end, rows.end)};
}

template <typename T>
T* pixel(const ImageView<T>& image, int x, int y) noexcept {
  return image.data() + y * image.stride() + x;
}

}  // namespace

void splat_nearest(std::span<const Footprint> footprints, Rows rows,
                   const ImageView<QuarterMm>& nearest) noexcept {
  STOF_CHECK(rows.begin >= 0 && rows.end <= nearest.height());
  if (nearest.width() < kLanes) {
    ref::splat_nearest(footprints, rows, nearest);
    return;
  }
  for (const Footprint& f : footprints) {
    const Rows some = common(f, rows);
    if (some.begin >= some.end) {
      continue;
    }
    const Columns all = columns(f, nearest.width());
    const uint16x8_t depth = vornq_u16(vdupq_n_u16(f.depth), all.inside);
    for (int k = 0; k < all.vectors; ++k) {
      QuarterMm* there = pixel(nearest, std::min(all.first + k * kLanes, all.last), some.begin);
      for (int y = some.begin; y < some.end; ++y) {
        vst1q_u16(there, vminq_u16(vld1q_u16(there), depth));
        there += nearest.stride();
      }
    }
  }
}

void splat_intervals(std::span<const Footprint> footprints, Rows rows,
                     const SplattedView& view) noexcept {
  STOF_CHECK(rows.begin >= 0 && rows.end <= view.nearest.height());
  STOF_CHECK(same_size(view.low, view.nearest) && same_size(view.high, view.nearest) &&
             same_size(view.flags, view.nearest));
  if (view.nearest.width() < kLanes) {
    ref::splat_intervals(footprints, rows, view);
    return;
  }
  const SplattedView to = view;  // a byte that is written could be part of what is referred to
  for (const Footprint& f : footprints) {
    const Rows some = common(f, rows);
    if (some.begin >= some.end) {
      continue;
    }
    const Columns all = columns(f, to.nearest.width());
    const Lanes lanes = lanes_of(f.value, all.inside);
    for (int k = 0; k < all.vectors; ++k) {
      const int x = std::min(all.first + k * kLanes, all.last);
      const QuarterMm* nearest = pixel(to.nearest, x, some.begin);
      QuarterMm* low = pixel(to.low, x, some.begin);
      QuarterMm* high = pixel(to.high, x, some.begin);
      std::uint8_t* flags = pixel(to.flags, x, some.begin);
      for (int y = some.begin; y < some.end; ++y) {
        unite(lanes, nearest, low, high, flags);
        nearest += to.nearest.stride();
        low += to.low.stride();
        high += to.high.stride();
        flags += to.flags.stride();
      }
    }
  }
}

void splat_interval(const FootprintValue& value, std::span<const QuarterMm> nearest,
                    std::span<QuarterMm> low, std::span<QuarterMm> high,
                    std::span<std::uint8_t> flags) noexcept {
  const std::size_t n = nearest.size();
  STOF_CHECK(low.size() == n && high.size() == n && flags.size() == n);
  const Lanes everywhere = lanes_of(value, vdupq_n_u16(0xFFFF));
  std::size_t x = 0;
  for (; x + kLanes <= n; x += kLanes) {
    unite(everywhere, nearest.data() + x, low.data() + x, high.data() + x, flags.data() + x);
  }
  ref::splat_interval(value, nearest.subspan(x), low.subspan(x), high.subspan(x), flags.subspan(x));
}

}  // namespace stof::dsp::neon
