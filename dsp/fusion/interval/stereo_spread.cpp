#include "dsp/fusion/interval/stereo_spread.h"

namespace stof::dsp {

SpreadTable spread_of(const MatchParams& params) noexcept {
  constexpr std::uint8_t kHalfStep = 6;  // with what the match itself errs by: 95 percent
  SpreadTable table = params.search == Search::kPaths ? kPathSpread : kBlockSpread;
  if (params.subpixel == Subpixel::kWhole) {
    for (std::uint8_t& half : table) {
      half = static_cast<std::uint8_t>(half + kHalfStep);
    }
  }
  return table;
}

}  // namespace stof::dsp
