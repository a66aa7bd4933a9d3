#include "lab/block/interest.h"

#include <algorithm>
#include <cstdlib>

#include "dsp/base/check.h"
#include "dsp/stereo/search/winner.h"

namespace stof::lab {

void interest_maxima(std::span<const std::uint8_t> derivative, int cap, int threshold,
                     std::span<std::uint8_t> mask) noexcept {
  const std::size_t n = derivative.size();
  STOF_CHECK(mask.size() == n && threshold >= 1 && threshold <= cap && cap <= 127);
  std::ranges::fill(mask, std::uint8_t{0});
  const auto size_at = [&](std::size_t x) noexcept { return std::abs(derivative[x] - cap); };
  int before = 0;  // beyond the ends there is nothing
  for (std::size_t begin = 0; begin < n;) {
    const int here = size_at(begin);
    std::size_t end = begin + 1;
    while (end < n && size_at(end) == here) {
      ++end;
    }
    const int after = end < n ? size_at(end) : 0;
    if (here >= threshold && here > before && here > after) {
      mask[begin + (end - 1 - begin) / 2] = 1;
    }
    before = here;
    begin = end;
  }
}

void interest_above(std::span<const std::uint8_t> derivative, int cap, int threshold,
                    std::span<std::uint8_t> mask) noexcept {
  STOF_CHECK(mask.size() == derivative.size() && threshold >= 1 && threshold <= cap && cap <= 127);
  for (std::size_t x = 0; x < mask.size(); ++x) {
    mask[x] = std::abs(derivative[x] - cap) >= threshold ? 1 : 0;
  }
}

template <typename Sum>
void keep_interesting(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right,
                      int min_disparity, int lanes, std::span<Sum> costs) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && right.size() == left.size() &&
             costs.size() == left.size() * count);
  const int width = static_cast<int>(left.size());
  for (int x = 0; x < width; ++x) {
    const std::span<Sum> pixel = costs.subspan(static_cast<std::size_t>(x) * count, count);
    if (left[static_cast<std::size_t>(x)] == 0) {
      std::ranges::fill(pixel, kNoCost<Sum>);
      continue;
    }
    for (int i = 0; i < lanes; ++i) {
      const int match = x - min_disparity - i;
      if (match < 0 || match >= width || right[static_cast<std::size_t>(match)] == 0) {
        pixel[static_cast<std::size_t>(i)] = kNoCost<Sum>;
      }
    }
  }
}

template <typename Sum>
void interesting_winners(std::span<const Sum> costs, int lanes,
                         std::span<std::int16_t> winners) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 &&
             costs.size() == winners.size() * count);
  for (std::size_t x = 0; x < winners.size(); ++x) {
    const std::span<const Sum> pixel = costs.subspan(x * count, count);
    const auto lowest = std::ranges::min_element(pixel);
    winners[x] =
        *lowest == kNoCost<Sum> ? kNoWinner : static_cast<std::int16_t>(lowest - pixel.begin());
  }
}

template void keep_interesting(std::span<const std::uint8_t>, std::span<const std::uint8_t>, int,
                               int, std::span<std::uint16_t>) noexcept;
template void keep_interesting(std::span<const std::uint8_t>, std::span<const std::uint8_t>, int,
                               int, std::span<std::uint32_t>) noexcept;
template void interesting_winners(std::span<const std::uint16_t>, int,
                                  std::span<std::int16_t>) noexcept;
template void interesting_winners(std::span<const std::uint32_t>, int,
                                  std::span<std::int16_t>) noexcept;

}  // namespace stof::lab
