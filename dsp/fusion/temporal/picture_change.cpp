#include "dsp/fusion/temporal/picture_change.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "dsp/fusion/temporal/cell_change.h"
#include "dsp/fusion/temporal/pixel_change.h"
#include "dsp/stereo/match_params.h"

namespace stof::dsp {
namespace {

// The last cell of a row or column also stands for what is left behind it.
int cells(int size) noexcept { return std::max(size / kCellSize, 1); }

template <typename T>
CellRows rows_of(const ImageView<T>& picture, int cell) noexcept {
  CellRows rows;
  for (int k = 0; k < kCellSize; ++k) {
    rows[index(k)] = picture.row_clamped(cell * kCellSize + k);
  }
  return rows;
}

// marks[x] = PictureChange::kPixel where one of 3x3 is not 0, else 0.
void mark_around(const ImageView<std::uint8_t>& pixels, int y,
                 std::span<std::uint8_t> marks) noexcept {
  const std::span<const std::uint8_t> above = pixels.row_clamped(y - 1);
  const std::span<const std::uint8_t> here = pixels.row(y);
  const std::span<const std::uint8_t> below = pixels.row_clamped(y + 1);
  std::array<std::uint8_t, kMaxImageWidth + 2> columns;  // one more at either end
  const std::size_t n = marks.size();
  columns[0] = 0;
  columns[n + 1] = 0;
  for (std::size_t x = 0; x < n; ++x) {
    columns[x + 1] = static_cast<std::uint8_t>(above[x] | here[x] | below[x]);
  }
  for (std::size_t x = 0; x < n; ++x) {
    marks[x] = static_cast<std::uint8_t>((columns[x] | columns[x + 1] | columns[x + 2]) &
                                         PictureChange::kPixel);
  }
}

// All bits that are set somewhere.
std::uint8_t any_of(std::span<const std::uint8_t> values) noexcept {
  std::uint8_t any = 0;
  for (const std::uint8_t value : values) {
    any = static_cast<std::uint8_t>(any | value);
  }
  return any;
}

template <typename T>
void clear(const ImageView<T>& image) noexcept {
  for (int y = 0; y < image.height(); ++y) {
    std::ranges::fill(image.row(y), T{0});
  }
}

}  // namespace

PictureChange::PictureChange(int width, int height, Arena& arena) noexcept
    : before_(arena.take_image<std::uint8_t>(width, height)),
      pixels_(arena.take_image<std::uint8_t>(width, height)),
      rows_(arena.take_filled(index(height), std::uint8_t{0})),
      changed_(arena.take_image<std::uint8_t>(cells(width), cells(height))),
      around_(arena.take_image<std::uint8_t>(cells(width), cells(height))),
      column_(arena.take_filled(index(cells(width) + 2 * kReach), std::uint8_t{0})) {
  STOF_CHECK(width <= kMaxImageWidth);
}

void PictureChange::take(ImageView<const std::uint8_t> picture) noexcept {
  for (int y = 0; y < picture.height(); ++y) {
    std::ranges::copy(picture.row(y), before_.row(y).begin());
  }
  clear(pixels_);
  std::ranges::fill(rows_, std::uint8_t{0});
  clear(around_);
}

void PictureChange::take_changed(ImageView<const std::uint8_t> picture) noexcept {
  for (int y = 0; y < picture.height(); ++y) {
    const std::span<const std::uint8_t> changed =
        changed_.row(std::min(y / kCellSize, changed_.height() - 1));
    if (std::ranges::max(changed) == 0) {
      continue;
    }
    const std::span<const std::uint8_t> now = picture.row(y);
    const std::span<std::uint8_t> before = before_.row(y);
    for (std::size_t cell = 0; cell < changed.size(); ++cell) {
      if (changed[cell] != 0) {
        const std::size_t begin = kCellSize * cell;
        const std::size_t end = cell + 1 < changed.size() ? begin + kCellSize : now.size();
        std::ranges::copy(now.subspan(begin, end - begin), before.subspan(begin).begin());
      }
    }
  }
}

// Tells how many cells have changed.
int PictureChange::compare(ImageView<const std::uint8_t> picture) noexcept {
  int count = 0;
  for (int cell = 0; cell < changed_.height(); ++cell) {
    const std::span<std::uint8_t> changed = changed_.row(cell);
    best::cell_change(rows_of(picture, cell), rows_of(before_, cell), changed);
    count +=
        static_cast<int>(changed.size() - index(static_cast<int>(std::ranges::count(changed, 0))));
    const bool last = cell + 1 == changed_.height();
    const int end = last ? picture.height() : (cell + 1) * kCellSize;
    for (int y = cell * kCellSize; y < end; ++y) {
      best::pixel_change(picture.row(y), before_.row(y), pixels_.row(y));
      rows_[index(y)] = any_of(pixels_.row(y));
    }
  }
  return count;
}

bool PictureChange::look(ImageView<const std::uint8_t> picture) noexcept {
  STOF_CHECK(same_size(picture, before_));
  const bool too_small = picture.width() < kCellSize;
  const bool compares = knows_ && !too_small;
  knows_ = true;
  if (!compares || kMovedShare * compare(picture) > changed_.width() * changed_.height()) {
    take(picture);
    return false;
  }
  take_changed(picture);
  widen();
  return true;
}

void PictureChange::widen() noexcept {
  const std::size_t n = index(changed_.width());
  const std::span<std::uint8_t> column = column_;
  const std::span<std::uint8_t> middle = column.subspan(kReach, n);
  for (int y = 0; y < changed_.height(); ++y) {
    std::ranges::fill(middle, std::uint8_t{0});
    for (int other = std::max(y - kReach, 0); other <= std::min(y + kReach, changed_.height() - 1);
         ++other) {
      const std::span<const std::uint8_t> changed = changed_.row(other);
      for (std::size_t x = 0; x < n; ++x) {
        middle[x] = static_cast<std::uint8_t>(middle[x] | changed[x]);
      }
    }
    const std::span<std::uint8_t> around = around_.row(y);
    std::ranges::fill(around, std::uint8_t{0});
    for (std::size_t shift = 0; shift <= 2 * kReach; ++shift) {
      for (std::size_t x = 0; x < n; ++x) {
        around[x] = static_cast<std::uint8_t>(around[x] | column[x + shift]);
      }
    }
  }
}

void PictureChange::mark(int y, std::span<std::uint8_t> marks) const noexcept {
  const int last = pixels_.height() - 1;
  const unsigned beside = rows_[index(std::max(y - 1, 0))] | rows_[index(std::min(y + 1, last))];
  if ((beside | rows_[index(y)]) != 0) {
    mark_around(pixels_, y, marks);
  } else {
    std::ranges::fill(marks, std::uint8_t{0});
  }
  const std::span<const std::uint8_t> around =
      around_.row(std::min(y / kCellSize, around_.height() - 1));
  if (std::ranges::max(around) == 0) {
    return;
  }
  for (std::size_t cell = 0; cell < around.size(); ++cell) {
    if (around[cell] != 0) {
      const std::size_t begin = kCellSize * cell;
      const std::size_t end = cell + 1 < around.size() ? begin + kCellSize : marks.size();
      for (std::uint8_t& mark : marks.subspan(begin, end - begin)) {
        mark = static_cast<std::uint8_t>(mark | kCell);
      }
    }
  }
}

}  // namespace stof::dsp
