#include "dsp/stereo/check/histogram.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"

namespace stof::dsp {
namespace {

std::size_t bin(Disparity disparity, int min_disparity, std::size_t bins) noexcept {
  const int whole = round_shift<int>(disparity.raw, Disparity::kFractionBits);
  return static_cast<std::size_t>(std::clamp(whole - min_disparity, 0, static_cast<int>(bins) - 1));
}

}  // namespace

void drop_rare(ImageView<Disparity> disparities, int min_disparity, int permille,
               std::span<std::uint32_t> counts) noexcept {
  STOF_CHECK(permille >= 0 && permille <= 1000 && !counts.empty());
  std::ranges::fill(counts, 0U);
  for (int y = 0; y < disparities.height(); ++y) {
    for (const Disparity disparity : disparities.row(y)) {
      if (disparity.valid()) {
        ++counts[bin(disparity, min_disparity, counts.size())];
      }
    }
  }
  const std::uint64_t pixels = static_cast<std::uint64_t>(disparities.width()) *
                               static_cast<std::uint64_t>(disparities.height());
  const std::uint64_t least = pixels * static_cast<std::uint64_t>(permille);
  for (int y = 0; y < disparities.height(); ++y) {
    for (Disparity& disparity : disparities.row(y)) {
      if (disparity.valid() &&
          std::uint64_t{counts[bin(disparity, min_disparity, counts.size())]} * 1000U < least) {
        disparity = Disparity::none();
      }
    }
  }
}

}  // namespace stof::dsp
