#include "dsp/fusion/interval/disparity_sigma.h"

namespace stof::dsp {

SigmaTable sigma_of(const MatchParams& params) noexcept {
  constexpr std::uint8_t kHalfStep = 6;  // with what the match itself errs by: 95 percent
  SigmaTable table = params.search == Search::kSemiGlobal ? kPathSigma : kBlockSigma;
  if (params.subpixel == Subpixel::kWhole) {
    for (std::uint8_t& half : table) {
      half = static_cast<std::uint8_t>(half + kHalfStep);
    }
  }
  return table;
}

}  // namespace stof::dsp
