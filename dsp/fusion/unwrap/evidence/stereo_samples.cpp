#include "dsp/fusion/unwrap/evidence/stereo_samples.h"

#include <algorithm>

#include "dsp/base/check.h"
#include "dsp/base/index.h"

namespace stof::dsp {
namespace {

constexpr int kLeastStepBits = 1;
constexpr int kMostStepBits = 6;

int samples(int size, int step_bits) noexcept { return (size + (1 << step_bits) - 1) >> step_bits; }

// With the border.
std::size_t grid_size(int columns, int rows) noexcept {
  return index(columns + 2 * kGridBorder) * index(rows + 2 * kGridBorder);
}

// The values of a row's samples; the last one stands for what is not there.
template <typename T>
void pick(std::span<const T> row, int step_bits, std::span<T> out) noexcept {
  const std::size_t step = std::size_t{1} << static_cast<unsigned>(step_bits);
  const std::size_t inside = (row.size() + step / 2 - 1) / step;  // of which the row has the place
  if (step == 2) {
    for (std::size_t i = 0; i < inside; ++i) {  // a constant: vectors
      out[i] = row[2 * i + 1];
    }
  } else {
    for (std::size_t i = 0; i < inside; ++i) {
      out[i] = row[i * step + step / 2];
    }
  }
  std::ranges::fill(out.subspan(inside), row.back());
}

int step_bits_for(double footprint) noexcept {
  int bits = kLeastStepBits;
  while (bits < kMostStepBits && kWindow << bits < footprint) {
    ++bits;
  }
  return bits;
}

}  // namespace

StereoSamples::StereoSamples(const StereoRig& rig, std::int16_t sigma, int min_disparity,
                             int disparities, int width, int height, double footprint,
                             Arena& arena) noexcept
    : tables_(make_interval_tables(rig, min_disparity, disparities, width, kMaxQuarterMm, arena)) {
  STOF_CHECK(sigma >= 0 && sigma <= kMaxStereoSigma);
  const std::size_t row = index(width);
  if (tables_.converging) {
    near_ = arena.take_passing<QuarterMm>(row);
    far_ = arena.take_passing<QuarterMm>(row);
  }
  some_ = arena.take_passing<Disparity>(row);
  half_ = arena.take_filled(row, static_cast<std::uint8_t>(2 * sigma));
  grid_.step_bits = step_bits_for(footprint);
  grid_.columns = samples(width, grid_.step_bits);
  grid_.rows = samples(height, grid_.step_bits);
  grid_.stride = grid_.columns + 2 * kGridBorder;
  low_ = arena.take_passing<QuarterMm>(grid_size(grid_.columns, grid_.rows));
  high_ = arena.take_passing<QuarterMm>(low_.size());
  const std::ptrdiff_t origin = kGridBorder * grid_.stride + kGridBorder;
  grid_.low = low_.data() + origin;
  grid_.high = high_.data() + origin;
}

void StereoSamples::take_row(std::span<const Disparity> disparity, std::span<QuarterMm> low,
                             std::span<QuarterMm> high) noexcept {
  const std::span<Disparity> some = some_.first(low.size());
  if (tables_.converging) {
    best::column_interval(disparity, half_, tables_.columns, near_, far_);
    pick<Disparity>(disparity, grid_.step_bits, some);
    pick<QuarterMm>(near_, grid_.step_bits, low);
    pick<QuarterMm>(far_, grid_.step_bits, high);
  } else {
    pick<Disparity>(disparity, grid_.step_bits, some);
    best::stereo_interval(some, half_.first(some.size()), tables_.disparity, low, high);
  }
  // A disparity without an interval lies beyond the tables' range. Values, not references: vectors.
  for (std::size_t i = 0; i < low.size(); ++i) {
    const QuarterMm near = low[i];
    const QuarterMm far = high[i];
    const QuarterMm beyond = some[i].valid() ? kMaxQuarterMm : kNoDepth;
    low[i] = far == kNoDepth ? kMaxQuarterMm : near;
    high[i] = far == kNoDepth ? beyond : far;
  }
}

// Nothing is known from element `begin` to `end`.
void StereoSamples::clear(std::size_t begin, std::size_t end) noexcept {
  std::ranges::fill(low_.subspan(begin, end - begin), kMaxQuarterMm);
  std::ranges::fill(high_.subspan(begin, end - begin), kNoDepth);
}

void StereoSamples::take(ImageView<const Disparity> disparity) noexcept {
  if (disparity.empty()) {
    clear(0, low_.size());
    return;
  }
  STOF_CHECK(samples(disparity.width(), grid_.step_bits) == grid_.columns &&
             samples(disparity.height(), grid_.step_bits) == grid_.rows);
  const std::size_t columns = index(grid_.columns);
  const int step = 1 << grid_.step_bits;
  std::size_t done = 0;  // what lies between rows is the border
  for (int j = 0; j < grid_.rows; ++j) {
    const int y = std::min(j * step + step / 2, disparity.height() - 1);
    const std::size_t at = static_cast<std::size_t>((j + kGridBorder) * grid_.stride + kGridBorder);
    clear(done, at);
    take_row(disparity.row(y), low_.subspan(at, columns), high_.subspan(at, columns));
    done = at + columns;
  }
  clear(done, low_.size());
}

}  // namespace stof::dsp
