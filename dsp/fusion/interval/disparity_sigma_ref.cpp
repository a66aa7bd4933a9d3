#include "dsp/fusion/interval/disparity_sigma.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"

namespace stof::dsp::ref {

void disparity_sigma(std::span<const Disparity> disparity, std::span<const std::uint8_t> ratio,
                     const SigmaTable& table, std::int16_t infinity_raw,
                     std::span<std::uint8_t> half) noexcept {
  STOF_CHECK(ratio.size() == disparity.size() && half.size() == disparity.size());
  for (std::size_t x = 0; x < half.size(); ++x) {
    if (!disparity[x].valid()) {
      half[x] = 0;
      continue;
    }
    const int most = std::max(disparity[x].raw - infinity_raw, 0) / kHalfWidthShare;
    const int wanted = table[ratio[x] / table.size()];
    half[x] = static_cast<std::uint8_t>(std::max<int>(std::min(wanted, most), kLeastHalfWidth));
  }
}

}  // namespace stof::dsp::ref
