#include "dsp/calib/stereo/remap_table.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Dense>

#include "dsp/base/check.h"
#include "dsp/base/index.h"

namespace stof::dsp {
namespace {

constexpr std::size_t kExceptionsPerPatch = 32;  // on average
// Places further outside of the raw picture than this are not followed: patches serve their inside.
constexpr double kMargin = 64;  // px

std::size_t patches_along(int pixels) noexcept {
  return (index(pixels) + kPatchSide - 1) / kPatchSide;
}
std::size_t patches_in(int width, int height) noexcept {
  return patches_along(width) * patches_along(height);
}

// 1/128 px; never on the last of `size` pixels, which has no neighbour.
int to_fixed(double place, int size) noexcept {
  return std::min(static_cast<int>(std::lround(place * kPlaceOne)), (size - 1) * kPlaceOne - 1);
}

// u, v: inside of the raw picture.
Place rounded(const Pinhole& raw, double u, double v) noexcept {
  const int x = to_fixed(u, raw.width);
  const int y = to_fixed(v, raw.height);
  return {.x = static_cast<std::uint16_t>(x / kPlaceOne),
          .y = static_cast<std::uint16_t>(y / kPlaceOne),
          .fraction_x = static_cast<std::uint8_t>(x % kPlaceOne),
          .fraction_y = static_cast<std::uint8_t>(y % kPlaceOne)};
}

Place place_at(const SourceMap& map, int column, int row) noexcept {
  const SourceMap::Place place = map.at(column, row);
  return rounded(map.raw(), place.u, place.v);
}

// Least squares: polynomials through all places of a patch.
using Samples = Eigen::Matrix<double, kPatchSide, kPatchSide>;
using Basis = Eigen::Matrix<double, kPatchSide, 4>;
using Fit = Eigen::Matrix<double, 4, kPatchSide>;

Fit fit_of(const Basis& basis) noexcept {
  return (basis.transpose() * basis).inverse() * basis.transpose();
}

struct Fits {
  Fit along;
  Fit down;

  Fits() noexcept {
    Basis columns;
    Basis lines;
    for (int k = 0; k < kPatchSide; ++k) {
      const double t = (2.0 * k - (kPatchSide - 1)) / kPatchSide;
      columns.row(k) << 1, k, patch_bend(k), patch_twist(k);
      lines.row(k) << 1, t, t * t, t * t * t;
    }
    along = fit_of(columns);
    down = fit_of(lines);
  }
};

// Whether every number of the patch's kernels stays in its 16 or 32 bits.
bool in_range(const PlacePatch& patch) noexcept {
  constexpr float kLargest = 2147483000.0F;
  for (int line = 0; line < kPatchSide; ++line) {
    const std::array<float, 8> numbers = patch_line(patch, line);
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const float* const n = &numbers[4 * axis];
      if (!(std::abs(n[0]) < kLargest && std::abs(n[1]) < kLargest && n[2] >= 0 && n[2] < 65536 &&
            n[3] >= 0 && n[3] < 65536)) {
        return false;
      }
      const auto whole = [&](int i) noexcept { return std::int64_t{static_cast<int>(n[i])}; };
      for (int k = 0; k < kPatchSide; ++k) {
        const std::int64_t sum = whole(0) + whole(1) * k + (whole(2) - kPatchBias) * patch_bend(k) +
                                 (whole(3) - kPatchBias) * patch_twist(k);
        if (sum != static_cast<std::int32_t>(sum)) {
          return false;
        }
      }
    }
  }
  return true;
}

std::int16_t saturated(int value) noexcept {
  using Limits = std::numeric_limits<std::int16_t>;
  return static_cast<std::int16_t>(std::clamp<int>(value, Limits::min(), Limits::max()));
}

// Sets what the patch says of one axis.
void set_axis(std::size_t axis, const Samples& places, int size, const Fits& fits,
              PlacePatch& patch) noexcept {
  const double middle = places(kPatchSide / 2, kPatchSide / 2);
  const int corner = std::clamp(static_cast<int>(middle), 0, size - 2);
  const Samples steps = (places.array() - corner).matrix();
  Eigen::Matrix4d numbers = fits.down * steps * fits.along.transpose();
  numbers *= kPlaceOne * double{1 << kPatchFractionBits};
  numbers(0, 0) += 1 << (kPatchFractionBits - 1);  // to the nearest step
  numbers(0, 2) += kPatchBias + 0.5;               // to the nearest number, once cut
  numbers(0, 3) += kPatchBias + 0.5;
  for (Eigen::Index power = 0; power < 4; ++power) {
    for (Eigen::Index i = 0; i < 4; ++i) {
      patch.powers[static_cast<std::size_t>(power)][4 * axis + static_cast<std::size_t>(i)] =
          static_cast<float>(numbers(power, i));
    }
  }
  (axis == 0 ? patch.x : patch.y) = static_cast<std::uint16_t>(corner);
  patch.low[axis] = saturated(-corner * kPlaceOne);
  patch.high[axis] = saturated((size - 1 - corner) * kPlaceOne - 1);
}

// The patch's pixels whose places it does not tell; lines, columns: of those that exist.
int wrong_places(const PlacePatch& patch, const Pinhole& raw, const Samples& u, const Samples& v,
                 int lines, int columns) noexcept {
  int wrong = 0;
  for (int line = 0; line < lines; ++line) {
    const std::array<float, 8> numbers = patch_line(patch, line);
    for (int k = 0; k < columns; ++k) {
      const Place place = rounded(raw, std::clamp(u(line, k), 0.0, raw.width - 1.0),
                                  std::clamp(v(line, k), 0.0, raw.height - 1.0));
      wrong += place_of(patch, numbers, k) == place ? 0 : 1;
    }
  }
  return wrong;
}

PlacePatch patch_at(const SourceMap& map, int column, int row, const Fits& fits) noexcept {
  const Pinhole& raw = map.raw();
  Samples u;
  Samples v;
  for (int line = 0; line < kPatchSide; ++line) {
    for (int k = 0; k < kPatchSide; ++k) {
      const SourceMap::Place place = map.unbounded(column + k, row + line);
      u(line, k) = std::clamp(place.u, -kMargin, raw.width - 1 + kMargin);
      v(line, k) = std::clamp(place.v, -kMargin, raw.height - 1 + kMargin);
    }
  }
  PlacePatch patch;
  set_axis(0, u, raw.width, fits, patch);
  set_axis(1, v, raw.height, fits, patch);
  patch.serves = in_range(patch);
  if (patch.serves) {
    patch.wrong = static_cast<std::uint16_t>(
        wrong_places(patch, raw, u, v, std::min(kPatchSide, map.rectified().height - row),
                     std::min(kPatchSide, map.rectified().width - column)));
  }
  return patch;
}

}  // namespace

RemapTable::RemapTable(const SourceMap& map, Arena& arena) noexcept
    : map_(map),
      columns_(patches_along(map.rectified().width)),
      patches_(arena.take<PlacePatch>(patches_in(map.rectified().width, map.rectified().height))),
      exceptions_(arena.take<Exception>(patches_.size() * kExceptionsPerPatch)),
      ends_(arena.take<std::uint32_t>(index(map.rectified().height))),
      seen_(arena.take<Seen>(index(map.rectified().height))) {
  const Pinhole& raw = map.raw();
  STOF_CHECK(raw.width >= 2 && raw.height >= 2 && raw.width <= 65536 && raw.height <= 65536);
  if (!arena.is_measuring()) {
    fit();
    choose();
    list();
  }
}

std::span<PlacePatch> RemapTable::patches_of(int row) const noexcept {
  return patches_.subspan(index(row / kPatchSide) * columns_, columns_);
}

std::span<const RemapTable::Exception> RemapTable::exceptions_of(int row) const noexcept {
  const std::size_t begin = row == 0 ? 0 : ends_[index(row) - 1];
  return exceptions_.subspan(begin, ends_[index(row)] - begin);
}

void RemapTable::fit() noexcept {
  const Fits fits;
  for (int row = 0; row < map_.rectified().height; row += kPatchSide) {
    for (int column = 0; column < map_.rectified().width; column += kPatchSide) {
      patches_of(row)[index(column / kPatchSide)] = patch_at(map_, column, row, fits);
    }
  }
}

// The patches with the fewest exceptions serve, as many as there is room for the exceptions of.
void RemapTable::choose() noexcept {
  std::size_t most = kPatchSide * kPatchSide;
  for (;; most -= most / 8 + 1) {
    std::size_t sum = 0;
    for (const PlacePatch& patch : patches_) {
      sum += patch.serves && patch.wrong <= most ? patch.wrong : 0U;
    }
    if (sum <= exceptions_.size()) {
      break;
    }
  }
  for (PlacePatch& patch : patches_) {
    patch.serves = patch.serves && patch.wrong <= most;
  }
}

// Exceptions, and what the camera saw.
void RemapTable::list() noexcept {
  const int width = map_.rectified().width;
  std::size_t count = 0;
  for (int y = 0; y < map_.rectified().height; ++y) {
    Seen seen;
    int pixels_seen = 0;
    std::array<float, 8> numbers{};
    for (int x = 0; x < width; ++x) {
      const PlacePatch& patch = patches_of(y)[index(x / kPatchSide)];
      if (x % kPatchSide == 0) {
        numbers = patch_line(patch, y % kPatchSide);
      }
      const SourceMap::Place at = map_.at(x, y);
      const Place place = rounded(map_.raw(), at.u, at.v);
      if (patch.serves && patch.wrong > 0 && place_of(patch, numbers, x % kPatchSide) != place) {
        exceptions_[count++] = {.column = static_cast<std::uint16_t>(x), .place = place};
      }
      if (at.inside) {
        seen.begin = pixels_seen == 0 ? x : seen.begin;
        seen.end = x + 1;
        ++pixels_seen;
      }
    }
    seen.torn = pixels_seen != seen.end - seen.begin;
    seen_[index(y)] = seen;
    ends_[index(y)] = static_cast<std::uint32_t>(count);
  }
}

void RemapTable::remap(ImageView<const std::uint8_t> source, int row,
                       std::span<std::uint8_t> out) const noexcept {
  STOF_CHECK(source.width() == map_.raw().width && source.height() == map_.raw().height);
  STOF_CHECK(out.size() == index(map_.rectified().width));
  const std::span<const PlacePatch> patches = patches_of(row);
  best::remap_row(source, patches, row % kPatchSide, out);
  for (const Exception& exception : exceptions_of(row)) {
    out[exception.column] = mix(source, exception.place);
  }
  for (std::size_t i = 0; i < patches.size(); ++i) {
    if (patches[i].serves) {
      continue;
    }
    const std::size_t begin = i * kPatchSide;
    for (std::size_t x = begin; x < std::min(begin + kPatchSide, out.size()); ++x) {
      out[x] = mix(source, place_at(map_, static_cast<int>(x), row));
    }
  }
}

Place RemapTable::place(int column, int row) const noexcept {
  const PlacePatch& patch = patches_of(row)[index(column / kPatchSide)];
  if (!patch.serves) {
    return place_at(map_, column, row);
  }
  const std::span<const Exception> exceptions = exceptions_of(row);
  const auto found = std::ranges::find(exceptions, column, &Exception::column);
  return found != exceptions.end()
             ? found->place
             : place_of(patch, patch_line(patch, row % kPatchSide), column % kPatchSide);
}

bool RemapTable::inside(int column, int row) const noexcept { return map_.at(column, row).inside; }

int RemapTable::computed_patches() const noexcept {
  return static_cast<int>(std::ranges::count(patches_, false, &PlacePatch::serves));
}

}  // namespace stof::dsp
