#include "dsp/stereo/refine/median.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {
namespace {

using Nine = std::array<int16x8_t, 9>;

// Every second missing value becomes the largest number, the others stay the smallest: then the
// middle of all nine is the (lower) middle of the valid ones.
void balance_missing(Nine& v) noexcept {
  const int16x8_t none = vdupq_n_s16(Disparity::none().raw);
  const int16x8_t top = vdupq_n_s16(std::numeric_limits<std::int16_t>::max());
  uint16x8_t raise = vdupq_n_u16(0);
  for (int16x8_t& value : v) {
    const uint16x8_t missing = vceqq_s16(value, none);
    value = vbslq_s16(vandq_u16(missing, raise), top, value);
    raise = veorq_u16(raise, missing);
  }
}

void sort(int16x8_t& low, int16x8_t& high) noexcept {
  const int16x8_t smaller = vminq_s16(low, high);
  high = vmaxq_s16(low, high);
  low = smaller;
}

// Three sorted columns: the median is that of the largest minimum, the median of the medians and
// the smallest maximum.
int16x8_t middle(Nine& v) noexcept {
  for (std::size_t k = 0; k < 9; k += 3) {
    sort(v[k], v[k + 1]);
    sort(v[k + 1], v[k + 2]);
    sort(v[k], v[k + 1]);
  }
  int16x8_t low = vmaxq_s16(vmaxq_s16(v[0], v[3]), v[6]);
  int16x8_t high = vminq_s16(vminq_s16(v[2], v[5]), v[8]);
  sort(v[1], v[4]);
  const int16x8_t mid = vmaxq_s16(v[1], vminq_s16(v[4], v[7]));
  sort(low, high);
  return vmaxq_s16(low, vminq_s16(high, mid));
}

// The three values at x - 1, x, x + 1 of a row that may be missing.
void load_three(ImageView<const Disparity> in, int y, std::size_t x, int16x8_t* out) noexcept {
  if (y < 0 || y >= in.height()) {
    out[0] = out[1] = out[2] = vdupq_n_s16(Disparity::none().raw);
    return;
  }
  const std::int16_t* const row = &in.row(y)[x].raw;
  out[0] = vld1q_s16(row - 1);
  out[1] = vld1q_s16(row);
  out[2] = vld1q_s16(row + 1);
}

void median_row(ImageView<const Disparity> in, int y, ImageView<Disparity> out) noexcept {
  const std::size_t n = static_cast<std::size_t>(in.width());
  const int16x8_t none = vdupq_n_s16(Disparity::none().raw);
  std::size_t x = 1;
  for (; x + 9 <= n; x += 8) {  // reads columns x - 1 .. x + 8
    Nine v;
    load_three(in, y - 1, x, v.data());
    load_three(in, y, x, v.data() + 3);
    load_three(in, y + 1, x, v.data() + 6);
    const uint16x8_t hole = vceqq_s16(v[4], none);
    balance_missing(v);
    vst1q_s16(&out.row(y)[x].raw, vbslq_s16(hole, none, middle(v)));
  }
  const int end = static_cast<int>(n);
  median_disparity_columns(in, y, 0, std::min(1, end), out);
  median_disparity_columns(in, y, std::min(static_cast<int>(x), end), end, out);
}

}  // namespace

void median_disparity(ImageView<const Disparity> in, Rows rows, ImageView<Disparity> out) noexcept {
  STOF_CHECK(same_size(in, out) && rows.begin >= 0 && rows.end <= in.height());
  for (int y = rows.begin; y < rows.end; ++y) {
    median_row(in, y, out);
  }
}

}  // namespace stof::dsp::neon
