#include "lab/pyramid/pyramid_rows.h"

#include <algorithm>
#include <cstddef>
#include <cstdlib>

#include "dsp/base/check.h"
#include "dsp/stereo/search/winner.h"

namespace stof::dsp::ref {
namespace {

std::int16_t between(std::int16_t a, std::int16_t b) noexcept {
  if (a == kNoWinner || b == kNoWinner) {
    return a == kNoWinner ? b : a;
  }
  return std::abs(a - b) <= 1 ? a : std::min(a, b);
}

}  // namespace

void halve_row(std::span<const std::uint8_t> upper, std::span<const std::uint8_t> lower,
               std::span<std::uint8_t> out) noexcept {
  STOF_CHECK(upper.size() == lower.size() && out.size() == (upper.size() + 1) / 2);
  for (std::size_t x = 0; x < out.size(); ++x) {
    const std::size_t right = std::min(2 * x + 1, upper.size() - 1);
    const int sum = upper[2 * x] + upper[right] + lower[2 * x] + lower[right];
    out[x] = static_cast<std::uint8_t>((sum + 2) / 4);
  }
}

void between_rows(std::span<const std::int16_t> above, std::span<const std::int16_t> below,
                  std::span<std::int16_t> out) noexcept {
  STOF_CHECK(above.size() == out.size() && below.size() == out.size());
  for (std::size_t x = 0; x < out.size(); ++x) {
    out[x] = between(above[x], below[x]);
  }
}

void spread_row(std::span<const std::int16_t> found, std::span<std::int16_t> out) noexcept {
  STOF_CHECK(found.size() == (out.size() + 1) / 2);
  for (std::size_t x = 0; x < out.size(); ++x) {
    const std::size_t next = std::min((x + 1) / 2, found.size() - 1);
    out[x] = between(found[x / 2], found[next]);
  }
}

}  // namespace stof::dsp::ref
