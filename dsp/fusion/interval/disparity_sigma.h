#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "dsp/base/fixed.h"
#include "dsp/base/kernel.h"
#include "dsp/stereo/match_params.h"

namespace stof::dsp {

// 2 sigma_d in 1/16 px for each sixteenth of the peak ratio (validation/peak_ratio.h): what 95
// percent of the matches with such a ratio err by at most, taken from four Middlebury pairs, among
// which it hardly differs, and checked on one without texture and on rendered rooms. A winner at
// two thirds of its best rival's cost may as well be a wrong one, and errs by as much as wrong
// matches do.
using SigmaTable = std::array<std::uint8_t, 16>;
inline constexpr SigmaTable kBlockSigma{7,  7,  7,  7,  8,  9,   10,  11,
                                        14, 22, 48, 80, 96, 128, 160, 176};
// Of sums over paths: what they favour at edges is more often wrong.
inline constexpr SigmaTable kPathSigma{8,  8,  10, 12,  14,  16,  17,  20,
                                       34, 60, 90, 112, 128, 144, 160, 176};

// How far matches of a search are believed.
struct MatchTrust {
  SigmaTable sigma_by_ratio = kBlockSigma;
  // Guesses at edges of the PMD are dropped where a match that many pixels away or less is much
  // nearer (resolve/ambiguity_resolver.h). Blocks fatten edges, and leave wide gaps at them.
  int doubt_px = 1 << 12;

  friend bool operator==(const MatchTrust&, const MatchTrust&) = default;
};

// What suits a search: sums over paths or blocks; half a step more where disparities are whole.
MatchTrust trust_of(const MatchParams& params) noexcept;

// An interval never reaches further than an eighth of the depth: beyond that it says nothing
// more, and its middle would leave the match.
inline constexpr int kHalfWidthShare = 8;

// half[x] = 2 sigma_d of disparity[x] in 1/16 px: table[ratio[x] / 16], but at most
// max(raw - infinity_raw, 0) / 8 rounded down and at least 4; 0 where there is no disparity.
// infinity_raw: the disparity of infinity, -doff in 1/16 px, +-16384. Equal lengths, any length,
// any alignment; no overlap.
using DisparitySigma = void(std::span<const Disparity> disparity,
                            std::span<const std::uint8_t> ratio, const SigmaTable& table,
                            std::int16_t infinity_raw, std::span<std::uint8_t> half) noexcept;
inline constexpr std::uint8_t kLeastHalfWidth = 4;

STOF_KERNEL(DisparitySigma, disparity_sigma, kNeon)

}  // namespace stof::dsp
