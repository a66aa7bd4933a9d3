#include "lab/fill.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "dsp/base/check.h"
#include "dsp/base/index.h"

namespace stof::lab {
namespace {

constexpr std::size_t kRank = 2;  // of those found, the farthest first

// None where there is none.
template <std::size_t kCount>
Disparity background(std::array<Disparity, kCount> nearest) noexcept {
  const auto end = std::partition(nearest.begin(), nearest.end(),
                                  [](Disparity d) noexcept { return d.valid(); });
  const std::size_t found = static_cast<std::size_t>(end - nearest.begin());
  if (found == 0) {
    return Disparity::none();
  }
  const std::size_t rank = std::min(kRank, found - 1);
  std::nth_element(nearest.begin(), nearest.begin() + rank, end,
                   [](Disparity a, Disparity b) noexcept { return a.raw < b.raw; });
  return nearest[rank];
}

}  // namespace

Filler::Filler(int width, int height, Arena& arena) noexcept
    : first_(arena.take<Nearest>(index(width) * index(height))),
      front_(arena.take<Front>(index(width))),
      next_(arena.take<Front>(index(width))),
      before_(arena.take<Disparity>(index(width))) {}

// Of column x in the row after the one that was passed last.
Filler::Nearest Filler::look(std::size_t x, Disparity in_row) const noexcept {
  Nearest found{in_row};
  for (std::size_t k = 0; k < kAcross; ++k) {
    const std::size_t from = x + k - 1;  // wraps beyond the row at its begin
    found[1 + k] = from < before_.size() ? front_[from].nearest[k] : Disparity::none();
  }
  return found;
}

void Filler::pass(std::span<const Disparity> row) noexcept {
  for (std::size_t x = 0; x < row.size(); ++x) {
    const Nearest behind = look(x, Disparity::none());
    for (std::size_t k = 0; k < kAcross; ++k) {
      next_[x].nearest[k] = row[x].valid() ? row[x] : behind[1 + k];
    }
  }
  std::swap(front_, next_);
}

void Filler::fill(ImageView<Disparity> disparities, ImageView<std::uint8_t> filled) noexcept {
  const std::size_t width = index(disparities.width());
  STOF_CHECK(same_size(disparities, filled) && width <= front_.size() &&
             width * index(disparities.height()) <= first_.size());
  const std::span<Disparity> all = before_;
  before_ = all.first(width);
  const auto begin = [&]() noexcept {
    std::ranges::fill(front_, Front{{Disparity::none(), Disparity::none(), Disparity::none()}});
  };
  begin();
  for (int y = 0; y < disparities.height(); ++y) {
    Disparity in_row = Disparity::none();
    for (std::size_t x = 0; x < width; ++x) {
      first_[index(y) * width + x] = look(x, in_row);
      in_row = disparities.row(y)[x].valid() ? disparities.row(y)[x] : in_row;
    }
    pass(disparities.row(y));
  }
  begin();
  for (int y = disparities.height() - 1; y >= 0; --y) {
    const std::span<Disparity> row = disparities.row(y);
    std::ranges::copy(row, before_.begin());
    Disparity in_row = Disparity::none();
    for (std::size_t x = width; x-- > 0;) {
      if (before_[x].valid()) {
        in_row = before_[x];
        continue;
      }
      std::array<Disparity, 2 * (1 + kAcross)> nearest;
      std::ranges::copy(first_[index(y) * width + x], nearest.begin());
      std::ranges::copy(look(x, in_row), nearest.begin() + 1 + kAcross);
      row[x] = background(nearest);
      filled.row(y)[x] = row[x].valid() ? std::uint8_t{1} : filled.row(y)[x];
    }
    pass(before_);
  }
  before_ = all;
}

}  // namespace stof::lab
