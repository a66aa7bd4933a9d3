#include "dsp/fusion/interval/disparity_sigma.h"

namespace stof::dsp {

MatchTrust trust_of(const MatchParams& params) noexcept {
  constexpr std::uint8_t kHalfStep = 6;  // with what the match itself errs by: 95 percent
  MatchTrust trust;
  if (params.search == Search::kSemiGlobal) {
    trust = {.sigma_by_ratio = kPathSigma, .doubt_px = 4};
  }
  if (params.subpixel == Subpixel::kWhole) {
    for (std::uint8_t& half : trust.sigma_by_ratio) {
      half = static_cast<std::uint8_t>(half + kHalfStep);
    }
  }
  return trust;
}

}  // namespace stof::dsp
