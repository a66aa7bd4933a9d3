#include "dsp/stereo/cost/arms.h"

#include <algorithm>
#include <cstddef>
#include <cstdlib>

#include "dsp/base/check.h"

namespace stof::dsp {
namespace {

// Steps from x in `direction`, as arms_along() says.
std::uint8_t arm(std::span<const std::uint8_t> row, int x, int direction,
                 const ArmParams& params) noexcept {
  const int n = static_cast<int>(row.size());
  const int room = std::min(direction < 0 ? x : n - 1 - x, params.longest);
  const auto grey = [&](int at) noexcept { return int{row[static_cast<std::size_t>(at)]}; };
  int steps = 0;
  while (steps < room &&
         std::abs(grey(x + direction * (steps + 1)) - grey(x)) <= params.difference) {
    ++steps;
  }
  return static_cast<std::uint8_t>(std::max(steps, std::min(room, 1)));
}

}  // namespace

void arms_along_columns(std::span<const std::uint8_t> row, const ArmParams& params,
                        std::size_t begin, std::size_t end, std::span<std::uint8_t> left,
                        std::span<std::uint8_t> right) noexcept {
  for (std::size_t x = begin; x < end; ++x) {
    left[x] = arm(row, static_cast<int>(x), -1, params);
    right[x] = arm(row, static_cast<int>(x), 1, params);
  }
}

namespace ref {

void arms_along(std::span<const std::uint8_t> row, const ArmParams& params,
                std::span<std::uint8_t> left, std::span<std::uint8_t> right) noexcept {
  STOF_CHECK(left.size() == row.size() && right.size() == row.size());
  arms_along_columns(row, params, 0, row.size(), left, right);
}

void arms_across(std::span<const std::uint8_t> row, std::span<const std::uint8_t* const> others,
                 const ArmParams& params, std::span<std::uint8_t> arms) noexcept {
  STOF_CHECK(arms.size() == row.size() && static_cast<int>(others.size()) <= params.longest);
  for (std::size_t x = 0; x < row.size(); ++x) {
    std::size_t steps = 0;
    while (steps < others.size() &&
           std::abs(int{others[steps][x]} - int{row[x]}) <= params.difference) {
      ++steps;
    }
    arms[x] = static_cast<std::uint8_t>(std::max(steps, std::min<std::size_t>(others.size(), 1)));
  }
}

}  // namespace ref
}  // namespace stof::dsp
