#include "dsp/stereo/rectify/rectify.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "dsp/base/avx2.h"
#include "dsp/base/check.h"

// The neon variant's way with sixteen pixels a step, eight in each half of a vector.
namespace stof::dsp::avx2 {
namespace {

constexpr int kLanes = 16;
constexpr int kWindow = 16;  // pixels of a source row that are looked at together
constexpr int kMostRows = 6;

// Pairs (bend, twist) of each second pixel, from an even or an odd one.
using Bends = std::array<std::int16_t, kPatchSide>;
constexpr Bends table_from(int first) noexcept {
  Bends table{};
  for (int i = 0; i < kPatchSide / 2; ++i) {
    const auto at = static_cast<std::size_t>(2 * i);
    table[at] = static_cast<std::int16_t>(patch_bend(first + 2 * i));
    table[at + 1] = static_cast<std::int16_t>(patch_twist(first + 2 * i));
  }
  return table;
}
alignas(32) constexpr Bends kEven = table_from(0);
alignas(32) constexpr Bends kOdd = table_from(1);

i16x16 shifted_right(i16x16 v, int bits_count) noexcept {
  return as<i16x16>(_mm256_srai_epi16(bits(v), bits_count));
}
i16x16 shifted_left(i16x16 v, int bits_count) noexcept {
  return as<i16x16>(_mm256_slli_epi16(bits(v), bits_count));
}
i16x16 shuffled(i16x16 v, __m256i index) noexcept {
  return as<i16x16>(_mm256_shuffle_epi8(bits(v), index));
}
i16x16 chosen(i16x16 mask, i16x16 yes, i16x16 no) noexcept {
  return as<i16x16>(_mm256_blendv_epi8(bits(no), bits(yes), bits(mask)));
}
// a[2 i] b[2 i] + a[2 i + 1] b[2 i + 1].
i32x8 pair_products(__m256i a, __m256i b) noexcept { return as<i32x8>(_mm256_madd_epi16(a, b)); }
// Lanes 0 of each half, and lanes 7.
i16x16 firsts(i16x16 v) noexcept { return shuffled(v, _mm256_set1_epi16(0x0100)); }
i16x16 lasts(i16x16 v) noexcept { return shuffled(v, _mm256_set1_epi16(0x0F0E)); }

// A, B, C, D of both axes.
i32x8 numbers_of(const PlacePatch& patch, float t) noexcept {
  const auto power = [&](std::size_t i) noexcept {
    return _mm256_loadu_ps(patch.powers[i].data());
  };
  const auto times = [](__m256 v, float f) noexcept { return _mm256_mul_ps(v, _mm256_set1_ps(f)); };
  __m256 sum = _mm256_add_ps(power(0), times(power(1), t));
  sum = _mm256_add_ps(sum, times(power(2), t * t));
  sum = _mm256_add_ps(sum, times(power(3), t * t * t));
  return as<i32x8>(_mm256_cvttps_epi32(sum)) -
         i32x8{0, 0, kPatchBias, kPatchBias, 0, 0, kPatchBias, kPatchBias};
}

// Walks along a line of a patch on one axis.
struct Walk {
  i32x8 even;   // A + B k of each second pixel
  i32x8 slope;  // B
  __m256i curve;
  i16x16 low, high;

  // Steps of 1/128 px from the patch's corner for pixels k .. k + 15.
  i16x16 next(int k) noexcept {
    const auto at = static_cast<std::size_t>(k);
    const i32x8 first = even + pair_products(curve, bits(load<i16x16>(&kEven[at])));
    const i32x8 second = even + slope + pair_products(curve, bits(load<i16x16>(&kOdd[at])));
    even = even + (slope << 4);
    // High halves are whole steps.
    const i16x16 steps = as<i16x16>(
        _mm256_blend_epi16(_mm256_srli_epi32(bits(first), kPatchFractionBits), bits(second), 0xAA));
    return smaller(larger(steps, low), high);
  }
};

// kAxis 0: x, 1: y.
template <int kAxis>
Walk walk_of(const PlacePatch& patch, i32x8 numbers) noexcept {
  const i32x8 slope = all(numbers[4 * kAxis + 1]);
  const i16x16 narrow = as<i16x16>(_mm256_packs_epi32(bits(numbers), bits(numbers)));
  const __m256i curves = bits(narrow);  // C, D of x in element 1, of y in element 5
  return {.even = all(numbers[4 * kAxis]) + slope * i32x8{0, 2, 4, 6, 8, 10, 12, 14},
          .slope = slope,
          .curve = _mm256_permutevar8x32_epi32(curves, _mm256_set1_epi32(4 * kAxis + 1)),
          .low = all(patch.low[kAxis]),
          .high = all(patch.high[kAxis])};
}

struct Sixteen {
  i16x16 x, y;  // whole columns and rows from the patch's corner
  i16x16 fraction_x, fraction_y;
};

// Pairs of neighbours (left, right) of both rows.
i16x16 mix_rows(i16x16 upper, i16x16 lower, const Sixteen& places) noexcept {
  // a (128 - f) + b f as a + (a (127 - f) + b f): weights are signed bytes.
  const __m256i weights = bits((places.fraction_x ^ all(std::int16_t{kPlaceOne - 1})) |
                               shifted_left(places.fraction_x, 8));
  const auto columns = [&](i16x16 row) noexcept {
    return as<i16x16>(_mm256_maddubs_epi16(bits(row), weights)) + (row & all(std::int16_t{0xFF}));
  };
  const i16x16 above = columns(upper);
  // As Q15: the rounded high half of a doubled product divides by 128.
  const i16x16 mixed =
      above + as<i16x16>(_mm256_mulhrs_epi16(bits(columns(lower) - above),
                                             bits(shifted_left(places.fraction_y, 8))));
  return shifted_right(mixed + all(std::int16_t{kPlaceOne / 2}), kPlaceFractionBits);
}

// Whether all columns lie in a window and all rows in 0 .. rows.
bool near_each_other(i16x16 column, i16x16 row, int rows) noexcept {
  const __m256i last_column = _mm256_set1_epi16(kWindow - 2);
  const __m256i last_row = _mm256_set1_epi16(static_cast<std::int16_t>(rows));
  const __m256i far = _mm256_or_si256(_mm256_subs_epu16(bits(column), last_column),
                                      _mm256_subs_epu16(bits(row), last_row));
  return _mm256_testz_si256(far, far) != 0;
}

// Places that lie too far from each other: pixel by pixel.
i16x16 mix_apart(const ImageView<const std::uint8_t>& source, const PlacePatch& patch,
                 const Sixteen& places) noexcept {
  i16x16 mixed{};
  for (int k = 0; k < kLanes; ++k) {
    mixed[k] = mix(source, {.x = static_cast<std::uint16_t>(patch.x + places.x[k]),
                            .y = static_cast<std::uint16_t>(patch.y + places.y[k]),
                            .fraction_x = static_cast<std::uint8_t>(places.fraction_x[k]),
                            .fraction_y = static_cast<std::uint8_t>(places.fraction_y[k])});
  }
  return mixed;
}

// What all pixels of a patch share.
struct Source {
  const ImageView<const std::uint8_t>& image;
  const std::uint8_t* corner;  // the patch's
  i16x16 most_left;            // of a window
  i16x16 most_top;             // of three rows
  __m256i strides;             // pairs (1, stride)
};

// The first columns and rows of both halves' windows.
struct Corners {
  i16x16 left, top;
};
Corners corners_of(const Source& source, i16x16 x, i16x16 y) noexcept {
  return {.left = smaller(smaller(firsts(x), lasts(x)), source.most_left),
          .top = smaller(smaller(firsts(y), lasts(y)), source.most_top)};
}

struct Windows {
  const std::uint8_t* first[2];
  __m256i index;

  Windows(const Source& source, const Corners& corners, i16x16 column) noexcept
      : index(bits((column | shifted_left(column, 8)) + all(std::int16_t{0x0100}))) {
    const __m256i at = _mm256_madd_epi16(
        _mm256_unpacklo_epi16(bits(corners.left), bits(corners.top)), source.strides);
    first[0] = source.corner + _mm_cvtsi128_si32(_mm256_castsi256_si128(at));
    first[1] = source.corner + _mm_cvtsi128_si32(_mm256_extracti128_si256(at, 1));
  }
  // Pairs of neighbours from rows that lie this far below.
  i16x16 pairs(std::ptrdiff_t below_first, std::ptrdiff_t below_second) const noexcept {
    const auto part = [](const std::uint8_t* at) noexcept {
      return _mm_loadu_si128(reinterpret_cast<const __m128i*>(at));  // NOLINT: any type
    };
    const __m256i both = _mm256_inserti128_si256(
        _mm256_castsi128_si256(part(first[0] + below_first)), part(first[1] + below_second), 1);
    return as<i16x16>(_mm256_shuffle_epi8(both, index));
  }
};

// Places in more than two rows.
[[gnu::noinline]] i16x16 mix_steep(const Source& source, const PlacePatch& patch,
                                   const Sixteen& places) noexcept {
  const Corners corners = corners_of(source, places.x, places.y);
  const i16x16 column = places.x - corners.left;
  const i16x16 row = places.y - corners.top;
  int rows = 2;
  while (!near_each_other(column, row, rows)) {
    if (++rows > kMostRows) {
      return mix_apart(source.image, patch, places);
    }
  }
  const Windows windows(source, corners, column);
  const int below = source.image.height() - 1 - patch.y;
  const auto pairs = [&](int y) noexcept {  // the last row of the source repeats
    const auto down = [&](int top) noexcept {
      return (y < below - top ? y : below - top) * source.image.stride();
    };
    return windows.pairs(down(corners.top[0]), down(corners.top[8]));
  };
  i16x16 next = pairs(1);
  i16x16 upper = pairs(0);
  i16x16 lower = next;
  for (int y = 1; y <= rows; ++y) {
    const i16x16 here = as<i16x16>(bits(row == all(static_cast<std::int16_t>(y))));
    upper = chosen(here, next, upper);
    next = pairs(y + 1);
    lower = chosen(here, next, lower);
  }
  return mix_rows(upper, lower, places);
}

Sixteen split(i16x16 x, i16x16 y) noexcept {
  const i16x16 below_one = all(std::int16_t{kPlaceOne - 1});
  return {.x = shifted_right(x, kPlaceFractionBits),
          .y = shifted_right(y, kPlaceFractionBits),
          .fraction_x = x & below_one,
          .fraction_y = y & below_one};
}

// Sixteen pixels, each in 16 bits. Neighbours lie in few rows and near to each other: windows of
// those rows, of which bytes are taken by shuffles.
i16x16 mix_sixteen(const Source& source, const PlacePatch& patch, i16x16 x, i16x16 y) noexcept {
  const Sixteen places = split(x, y);
  const Corners corners = corners_of(source, places.x, places.y);
  const i16x16 column = places.x - corners.left;
  const i16x16 row = places.y - corners.top;
  if (!near_each_other(column, row, 1)) {
    return mix_steep(source, patch, split(x, y));
  }
  const Windows windows(source, corners, column);
  const std::ptrdiff_t stride = source.image.stride();
  const i16x16 middle = windows.pairs(stride, stride);
  const i16x16 here = as<i16x16>(bits(row == all(std::int16_t{1})));
  return mix_rows(chosen(here, middle, windows.pairs(0, 0)),
                  chosen(here, windows.pairs(2 * stride, 2 * stride), middle), places);
}

i16x16 at_most(int value) noexcept {
  constexpr int kFar = 16384;
  return all(static_cast<std::int16_t>(value < kFar ? value : kFar));
}

// All 32 pixels of a patch's line.
u8x32 remap_patch(const ImageView<const std::uint8_t>& image, const PlacePatch& patch,
                  float t) noexcept {
  const i32x8 numbers = numbers_of(patch, t);
  Walk along = walk_of<0>(patch, numbers);
  Walk down = walk_of<1>(patch, numbers);
  const Source source{.image = image,
                      .corner = image.data() + patch.y * image.stride() + patch.x,
                      .most_left = at_most(image.width() - kWindow - patch.x),
                      .most_top = at_most(image.height() - 3 - patch.y),
                      .strides = _mm256_set1_epi32(static_cast<int>(image.stride()) * 65536 + 1)};
  __m256i mixed[2];
  for (int i = 0; i < 2; ++i) {
    const i16x16 x = along.next(i * kLanes);
    const i16x16 y = down.next(i * kLanes);
    mixed[i] = bits(mix_sixteen(source, patch, x, y));
  }
  const __m256i packed = _mm256_packus_epi16(mixed[0], mixed[1]);  // eights 0 2 1 3
  return as<u8x32>(_mm256_permute4x64_epi64(packed, 0b11'01'10'00));
}

}  // namespace

void remap_row(ImageView<const std::uint8_t> source, std::span<const PlacePatch> patches, int line,
               std::span<std::uint8_t> out) noexcept {
  STOF_CHECK(out.size() <= patches.size() * kPatchSide && line >= 0 && line < kPatchSide);
  if (source.width() < kWindow || source.height() < 3 || source.stride() > 32767) {
    ref::remap_row(source, patches, line, out);
    return;
  }
  const float t = static_cast<float>(2 * line - (kPatchSide - 1)) / kPatchSide;
  std::uint8_t* to = out.data();
  std::size_t rest = out.size();
  for (const PlacePatch& patch : patches) {
    const std::size_t count = rest < kPatchSide ? rest : kPatchSide;
    if (patch.serves && count == kPatchSide) {
      store(to, remap_patch(source, patch, t));
    } else if (patch.serves) {
      std::uint8_t whole[kPatchSide];
      store(whole, remap_patch(source, patch, t));
      for (std::size_t i = 0; i < count; ++i) {
        to[i] = whole[i];
      }
    }
    to += count;
    rest -= count;
  }
}

}  // namespace stof::dsp::avx2
