#include "dsp/fusion/drift/picture_shift.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <utility>

#include "dsp/base/check.h"
#include "dsp/base/index.h"

namespace stof::dsp {
namespace {

// Of at most so many rows: their sums fit into 16 bits, and the noise of a mean of a hundred pixels
// is a tenth of theirs.
constexpr int kMostRows = 256;
// Fraction of a grey level in a profile.
constexpr int kLevel = 64;
// A slope is the sum of two values less that of the two before, so it begins so far inside.
constexpr int kInside = 2;
// The least difference over the mean of all shifts (chosen; drives through the corridor lie well
// below).
constexpr double kDistinct = 0.6;
// Slopes that differ by no more are those of one picture: a noise of 2.5 levels makes 0.4 of it in
// columns of 240 px.
constexpr double kSame = 0.5 * kLevel;
constexpr double kStandsPx = 0.25;

// Slope of a profile at i, four times a grey level a pixel.
std::int32_t slope(std::span<const std::uint16_t> profile, int i) noexcept {
  return profile[index(i + 1)] + profile[index(i)] - profile[index(i - 1)] - profile[index(i - 2)];
}

// Mean difference of both slopes where the content moved by `shift`.
double difference(std::span<const std::uint16_t> now, std::span<const std::uint16_t> before,
                  int shift) noexcept {
  const int n = static_cast<int>(now.size());
  const int begin = std::max(shift, 0) + kInside;
  const int end = n + std::min(shift, 0) - 1;
  std::int64_t sum = 0;
  for (int i = begin; i < end; ++i) {
    sum += std::abs(slope(now, i) - slope(before, i - shift));
  }
  return static_cast<double>(sum) / std::max(end - begin, 1);
}

// Of the two shifts beside the best one, the better: where between them the least is. Differences
// of absolute values rise alike to both sides.
double fraction(double left, double best, double right) noexcept {
  const double rise = std::max(left, right) - best;
  return rise > 0 ? (left - right) / (2 * rise) : 0;
}

// In pixels; nothing where nobody can tell.
std::optional<double> shift_of(std::span<const std::uint16_t> now,
                               std::span<const std::uint16_t> before, int reach) noexcept {
  if (difference(now, before, 0) <= kSame) {
    return 0;
  }
  int best = 0;
  double least = difference(now, before, 0);
  double sum = 0;
  for (int shift = -reach; shift <= reach; ++shift) {
    const double here = difference(now, before, shift);
    sum += here;
    if (here < least) {
      least = here;
      best = shift;
    }
  }
  if (std::abs(best) == reach || !(least < kDistinct * sum / (2 * reach + 1))) {
    return std::nullopt;
  }
  const double found =
      best + fraction(difference(now, before, best - 1), least, difference(now, before, best + 1));
  return std::abs(found) < kStandsPx ? 0 : found;
}

// The means of all columns, and of all rows.
void profile(ImageView<const std::uint8_t> picture, std::span<std::uint16_t> columns,
             std::span<std::uint16_t> rows) noexcept {
  std::ranges::fill(columns, std::uint16_t{0});
  const int step = (picture.height() + kMostRows - 1) / kMostRows;
  for (int y = 0; y < picture.height(); ++y) {
    const std::span<const std::uint8_t> row = picture.row(y);
    int sum = 0;
    for (const std::uint8_t grey : row) {
      sum += grey;
    }
    rows[index(y)] = static_cast<std::uint16_t>(kLevel * sum / picture.width());
    if (y % step == 0) {
      for (std::size_t x = 0; x < row.size(); ++x) {
        columns[x] = static_cast<std::uint16_t>(columns[x] + row[x]);
      }
    }
  }
  const int summed = (picture.height() + step - 1) / step;
  for (std::uint16_t& column : columns) {
    column = static_cast<std::uint16_t>(kLevel * column / summed);
  }
}

}  // namespace

PictureShift::PictureShift(int width, int height, Arena& arena) noexcept
    : columns_{.now = arena.take<std::uint16_t>(index(width)),
               .before = arena.take<std::uint16_t>(index(width))},
      rows_{.now = arena.take<std::uint16_t>(index(height)),
            .before = arena.take<std::uint16_t>(index(height))} {}

std::optional<Shift> PictureShift::look(ImageView<const std::uint8_t> picture) noexcept {
  STOF_CHECK(index(picture.width()) == columns_.now.size() &&
             index(picture.height()) == rows_.now.size());
  const int reach = picture.width() / kReachShare;
  if (picture.height() < 4 * reach || reach < 2) {  // too small to tell
    return std::nullopt;
  }
  std::swap(columns_.now, columns_.before);
  std::swap(rows_.now, rows_.before);
  profile(picture, columns_.now, rows_.now);
  if (!std::exchange(knows_, true)) {
    return std::nullopt;
  }
  const std::optional<double> x = shift_of(columns_.now, columns_.before, reach);
  const std::optional<double> y = shift_of(rows_.now, rows_.before, reach);
  return x && y ? std::optional(Shift{.x = *x, .y = *y}) : std::nullopt;
}

}  // namespace stof::dsp
