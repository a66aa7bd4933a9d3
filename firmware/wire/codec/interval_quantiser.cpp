#include "firmware/wire/codec/interval_quantiser.h"

#include <algorithm>
#include <limits>

#include "firmware/wire/codec/x86_target.h"

namespace stof::wire {
namespace {

constexpr unsigned kMaxU16 = std::numeric_limits<std::uint16_t>::max();

struct Counts {
  std::size_t pixels = 0;  // with depth
  std::size_t narrow = 0;  // of them: narrower than asked
  std::size_t wide = 0;    // of all: wider than kMostQuantisedWidth
};

// Counters of 16 bits: a row has no more pixels, and they lie side by side in a vector.
void count_row(std::span<const dsp::QuarterMm> depth, std::span<const dsp::QuarterMm> width,
               unsigned least, Counts& counts) noexcept {
  std::uint16_t pixels = 0;
  std::uint16_t narrow = 0;
  std::uint16_t wide = 0;
  const auto bound = static_cast<std::uint16_t>(least);
  for (std::size_t x = 0; x < depth.size(); ++x) {
    const bool valid = depth[x] != dsp::kNoDepth;
    const bool below = width[x] < bound;
    pixels = static_cast<std::uint16_t>(pixels + (valid ? 1 : 0));
    narrow = static_cast<std::uint16_t>(narrow + (valid && below ? 1 : 0));
    wide = static_cast<std::uint16_t>(wide + (width[x] > kMostQuantisedWidth ? 1 : 0));
  }
  counts.pixels += pixels;
  counts.narrow += narrow;
  counts.wide += wide;
}

unsigned in_units(unsigned depth, unsigned scale) noexcept {
  const unsigned half = (1U << scale) / 2;
  const unsigned units = std::clamp((depth + half) >> scale, 1U, kMaxU16 >> scale);
  return depth == dsp::kNoDepth ? 0 : units;
}

void depth_row(std::span<const dsp::QuarterMm> depth, unsigned scale,
               std::span<std::uint16_t> out) noexcept {
  std::ranges::transform(depth, out.begin(), [scale](dsp::QuarterMm d) {
    return static_cast<std::uint16_t>(in_units(d, scale));
  });
}

void width_row(std::span<const dsp::QuarterMm> depth, std::span<const dsp::QuarterMm> width,
               unsigned scale, std::span<std::uint16_t> out) noexcept {
  std::ranges::transform(depth, width, out.begin(), [scale](dsp::QuarterMm d, dsp::QuarterMm w) {
    const unsigned rounded = in_units(d, scale) << scale;
    const unsigned moved = rounded > d ? rounded - d : d - rounded;
    return static_cast<std::uint16_t>(w + 2 * moved);
  });
}

STOF_WIRE_AVX2 void count_row_avx2(std::span<const dsp::QuarterMm> depth,
                                   std::span<const dsp::QuarterMm> width, unsigned least,
                                   Counts& counts) noexcept {
  count_row(depth, width, least, counts);
}
STOF_WIRE_AVX2 void depth_row_avx2(std::span<const dsp::QuarterMm> depth, unsigned scale,
                                   std::span<std::uint16_t> out) noexcept {
  depth_row(depth, scale, out);
}
STOF_WIRE_AVX2 void width_row_avx2(std::span<const dsp::QuarterMm> depth,
                                   std::span<const dsp::QuarterMm> width, unsigned scale,
                                   std::span<std::uint16_t> out) noexcept {
  width_row(depth, width, scale, out);
}

}  // namespace

std::uint8_t quantiser_scale(const dsp::DepthMap& map, int first) noexcept {
  const int end = std::min(first + kQuantiserRows, map.depth.height());
  const auto count = uses_avx2() ? count_row_avx2 : count_row;
  for (int scale = kMostQuantiserScale; scale > 0; --scale) {
    Counts counts;
    for (int y = first; y < end; ++y) {
      count(map.depth.row(y), map.width.row(y), kQuantiserPart << scale, counts);
    }
    if (counts.pixels == 0 || counts.wide > 0) {
      return 0;
    }
    if (counts.narrow * kQuantiserNarrow <= counts.pixels) {
      return static_cast<std::uint8_t>(scale);
    }
  }
  return 0;
}

void quantise_depth(std::span<const dsp::QuarterMm> depth, unsigned scale,
                    std::span<std::uint16_t> out) noexcept {
  (uses_avx2() ? depth_row_avx2 : depth_row)(depth, scale, out);
}

void grow_width(std::span<const dsp::QuarterMm> depth, std::span<const dsp::QuarterMm> width,
                unsigned scale, std::span<std::uint16_t> out) noexcept {
  (uses_avx2() ? width_row_avx2 : width_row)(depth, width, scale, out);
}

void quantise_width(std::span<std::uint16_t> width, unsigned scale) noexcept {
  const unsigned most = (1U << scale) - 1;
  std::ranges::transform(width, width.begin(), [scale, most](std::uint16_t w) {
    return static_cast<std::uint16_t>((w + most) >> scale);
  });
}

}  // namespace stof::wire
