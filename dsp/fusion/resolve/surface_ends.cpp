#include "dsp/fusion/resolve/surface_ends.h"

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <limits>

#include "dsp/base/index.h"
#include "dsp/fusion/resolve/surrounding_matches.h"

namespace stof::dsp {
namespace {

constexpr int kBack = 6;  // px
constexpr int kOn = kSupportRings.back();
constexpr int kLeastStep = 4;  // grey levels: noise

// Of steps from one pixel to the next.
int greatest_step(const std::uint8_t* pixel, std::ptrdiff_t next, int steps) noexcept {
  int greatest = 0;
  for (int k = 0; k < steps; ++k, pixel += next) {
    greatest = std::max(greatest, std::abs(pixel[next] - pixel[0]));
  }
  return greatest;
}

}  // namespace

int beyond_edge(const MatchedView& view, const SurfacePixel& pixel) noexcept {
  constexpr int kNowhere = std::numeric_limits<int>::min();
  if (view.picture.empty()) {
    return 0;
  }
  int beyond = kNowhere;
  // before, behind: pixels of the picture to that side.
  const auto ask = [&](std::ptrdiff_t match_step, std::ptrdiff_t grey_step, int behind,
                       int before) noexcept {
    const Disparity* const match = &view.disparity.row(pixel.y)[index(pixel.x)];
    const auto ends = [&](int away) noexcept {
      // None is far from every disparity.
      return away <= before && std::abs(match[away * match_step].raw - pixel.raw) > pixel.most;
    };
    if (!ends(kSupportRings.front()) && !ends(kSupportRings.back())) {
      return;
    }
    const std::uint8_t* const grey = &view.picture.row(pixel.y)[index(pixel.x)];
    const int back = greatest_step(grey, -grey_step, std::min(behind, kBack));
    const int on = greatest_step(grey, grey_step, std::min(before, kOn));
    beyond = std::max(beyond, log2_q4(kLeastStep + back) - log2_q4(kLeastStep + on));
  };
  const int right = view.disparity.width() - 1 - pixel.x;
  const int below = view.disparity.height() - 1 - pixel.y;
  ask(-1, -1, right, pixel.x);
  ask(1, 1, pixel.x, right);
  ask(-view.disparity.stride(), -view.picture.stride(), below, pixel.y);
  ask(view.disparity.stride(), view.picture.stride(), pixel.y, below);
  return beyond == kNowhere ? 0 : beyond;
}

}  // namespace stof::dsp
