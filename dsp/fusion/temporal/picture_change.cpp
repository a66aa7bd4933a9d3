#include "dsp/fusion/temporal/picture_change.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "dsp/fusion/temporal/cell_change.h"

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

}  // namespace

PictureChange::PictureChange(int width, int height, Arena& arena) noexcept
    : before_(arena.take_image<std::uint8_t>(width, height)),
      changed_(arena.take_image<std::uint8_t>(cells(width), cells(height))),
      around_(arena.take_image<std::uint8_t>(cells(width), cells(height))),
      column_(arena.take_filled(index(cells(width) + 2 * kReach), std::uint8_t{0})) {}

void PictureChange::take(ImageView<const std::uint8_t> picture) noexcept {
  for (int y = 0; y < picture.height(); ++y) {
    std::ranges::copy(picture.row(y), before_.row(y).begin());
  }
  for (int y = 0; y < around_.height(); ++y) {
    std::ranges::fill(around_.row(y), std::uint8_t{0});
  }
}

void PictureChange::take_changed(ImageView<const std::uint8_t> picture) noexcept {
  for (int y = 0; y < picture.height(); ++y) {
    const std::span<const std::uint8_t> changed =
        changed_.row(std::min(y / kCellSize, changed_.height() - 1));
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

bool PictureChange::look(ImageView<const std::uint8_t> picture) noexcept {
  STOF_CHECK(same_size(picture, before_));
  const bool too_small = picture.width() < kCellSize;
  if (!knows_ || too_small) {
    take(picture);
    knows_ = true;
    return false;
  }
  int count = 0;
  for (int y = 0; y < changed_.height(); ++y) {
    const std::span<std::uint8_t> changed = changed_.row(y);
    best::cell_change(rows_of(picture, y), rows_of(before_, y), changed);
    count +=
        static_cast<int>(changed.size() - index(static_cast<int>(std::ranges::count(changed, 0))));
  }
  if (kMovedShare * count > changed_.width() * changed_.height()) {
    take(picture);
    return false;
  }
  take_changed(picture);
  widen();
  return true;
}

void PictureChange::widen() noexcept {
  const std::span<std::uint8_t> middle = column_.subspan(kReach, index(changed_.width()));
  for (int y = 0; y < changed_.height(); ++y) {
    std::ranges::fill(middle, std::uint8_t{0});
    for (int other = std::max(y - kReach, 0); other <= std::min(y + kReach, changed_.height() - 1);
         ++other) {
      const std::span<const std::uint8_t> changed = changed_.row(other);
      for (std::size_t x = 0; x < changed.size(); ++x) {
        middle[x] = static_cast<std::uint8_t>(middle[x] | changed[x]);
      }
    }
    const std::span<std::uint8_t> around = around_.row(y);
    for (std::size_t x = 0; x < around.size(); ++x) {
      around[x] = std::ranges::max(column_.subspan(x, 2 * kReach + 1));
    }
  }
}

void PictureChange::add_to(int y, std::span<std::uint8_t> row) const noexcept {
  const std::span<const std::uint8_t> around =
      around_.row(std::min(y / kCellSize, around_.height() - 1));
  for (std::size_t cell = 0; cell < around.size(); ++cell) {
    if (around[cell] != 0) {
      const std::size_t begin = kCellSize * cell;
      const std::size_t end = cell + 1 < around.size() ? begin + kCellSize : row.size();
      std::ranges::fill(row.subspan(begin, end - begin), std::uint8_t{255});
    }
  }
}

}  // namespace stof::dsp
