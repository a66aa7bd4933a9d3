#pragma once

#include <cstdint>
#include <optional>

#include "dsp/base/status.h"
#include "dsp/stereo/match_params.h"
#include "lab/dsp_names.h"

// How the chapter's experiments match a pair: the appliance's options, and more.
namespace stof::lab {

// The cost of two pixels. Pictures are grey values or, with a prefilter, their derivative.
enum class Cost : std::uint8_t {
  kSad,        // |L - R|, 0..255
  kSsd,        // (L - R)^2, 0..65025
  kCensus5x5,  // Hamming distance of 24 bits, 0..24
  kCensus9x7,  // Hamming distance of 62 bits, 0..62
  // Census 7x7, grey values and their derivative, averaged over a cross-shaped region of pixels
  // that look alike (dsp/stereo/cost/aggregated_ad_census.h), 0..26. Has neither block nor
  // prefilter.
  kAdCensus,
};

enum class Method : std::uint8_t {
  kWinnerTakesAll,
  kDynamicProgramming,  // of each row, with occlusions and the ordering constraint
  kScanlineOptimisation,
  kSemiGlobal,  // the energy of scanline optimisation over several directions
};

enum class BlockShape : std::uint8_t {
  kFixed,
  kCross,   // block_width x block_height at most, grown along the row and column of the centre
  kRegion,  // grown by whole rows and columns in turn
};

// Which positions are matched, by the size of the derivative.
enum class Interest : std::uint8_t {
  kMaxima,         // local maxima of at least half the prefilter's cap
  kTwoThresholds,  // left: two thirds of the cap, right: one third
};

// The appliance's parameters and more. `search` follows from the others; `smoothness` has room for
// more, in the units of one pixel's cost: a block of n pixels counts n times as much.
struct MatchParams : dsp::MatchParams {
  Cost cost = Cost::kSad;
  Method method = Method::kWinnerTakesAll;
  BlockShape block_shape = BlockShape::kFixed;
  // kDynamicProgramming: a pixel that only one camera sees; without it default_occlusion(cost).
  std::optional<int> occlusion = std::nullopt;
  int directions = 4;  // of kSemiGlobal: 2, 4, 5 or 8
  // Only interesting positions are matched; needs a prefilter.
  std::optional<Interest> interest = std::nullopt;
  // kScanlineOptimisation searches only this many px to either side of what winner takes all found
  // nearby.
  std::optional<int> band = std::nullopt;
  // Coarse to fine (pyramid/pyramid.h): 1 begins at half size, 2 at a quarter; finer sizes search
  // near what was found, large blocks at every second pixel of every second row.
  std::optional<int> pyramid_levels = std::nullopt;
  bool fill = false;  // from the background; every filled pixel is marked (Matcher::filled)

  friend bool operator==(const MatchParams&, const MatchParams&) = default;
};

inline constexpr int kMaxPenalty = 65535;  // of smoothness and occlusion

// Empty ("") when the parameters can be used together, else what cannot and what to do, for a
// message.
const char* problem(const MatchParams& params) noexcept;

// kOk, kInvalidArgument (a value outside its range, or a problem()) or kTooLarge.
Status check(const MatchParams& params, int width, int height) noexcept;

// The same for every scene.
dsp::Smoothness default_smoothness(Cost cost) noexcept;
int default_occlusion(Cost cost) noexcept;

// The block, cost and prefilter that suit a method; dense, without any check.
MatchParams method_defaults(Method method) noexcept;

// The parameters that match as the appliance does with these.
MatchParams as_the_appliance(const dsp::MatchParams& params) noexcept;
// Whether the winners are lowest of sums over paths, not of costs.
bool sums_paths(const MatchParams& params) noexcept;

// The appliance's parameters for the same map, but for `fill`; none where it has no such search.
std::optional<dsp::MatchParams> appliance_params(const MatchParams& params) noexcept;

}  // namespace stof::lab
