#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "dsp/base/status.h"
#include "dsp/stereo/refine/subpixel.h"

// How a stereo pair is matched. Every field has one meaning; "off" is never a number.
namespace stof::dsp {

enum class Search : std::uint8_t {
  // Winner takes all on sums of absolute differences of derivatives over fixed blocks
  // (search/block_search.h).
  kBlocks,
  // Semi-global over four directions. Its cost is census 7x7, grey values and their derivative,
  // averaged over neighbours that look alike (search/semi_global_search.h).
  kSemiGlobal,
};

enum class Subpixel : std::uint8_t {
  kWhole,         // whole disparities
  kEquiangular,   // fit of the costs by two lines of equal slope
  kParabola,      // fit of the costs by a parabola
  kLeastSquares,  // shift of the grey values; what moves by more than half a pixel is dropped
};

constexpr CostFit cost_fit(Subpixel subpixel) noexcept {
  if (subpixel == Subpixel::kEquiangular) {
    return CostFit::kEquiangular;
  }
  return subpixel == Subpixel::kParabola ? CostFit::kParabola : CostFit::kNone;
}

// Penalties for a change of disparity between neighbours, in the units of one pixel's cost.
struct Smoothness {
  int small_step = 0;  // P1: by one
  int large_step = 0;  // P2: by more; halved and quartered where the grey value changes

  friend bool operator==(const Smoothness&, const Smoothness&) = default;
};

// One field for each setting of depth.match.
struct MatchParams {
  int min_disparity = 0;  // px, may be negative (toed-in rigs)
  int disparities = 64;   // candidates min .. min + disparities - 1, at least 1
  Search search = Search::kBlocks;
  int block_width = 16;   // px, 1..64; of kBlocks and Subpixel::kLeastSquares
  int block_height = 16;  // px, 1..64
  bool equalise = false;  // bring the right picture to the left one's mean and contrast,
                          // of what both can see in the middle of the search range
  bool smooth = false;    // 3x3 binomial, before any derivative
  // Horizontal derivative (Sobel), clipped to +-cap, 1..127: what kBlocks and min_texture look at.
  // The larger the block, the smaller the cap that its sums have room for.
  std::optional<int> prefilter_cap = 15;

  // For kSemiGlobal; without it kDefaultSmoothness.
  std::optional<Smoothness> smoothness = std::nullopt;
  // Each match may be given a guide (cost/candidate_mask.h): which candidates each pixel may take.
  bool guided = false;

  // Largest difference in px between a match and the match of the match; without it no check.
  std::optional<int> left_right_tolerance = std::nullopt;
  // A rival candidate (not a neighbour) must cost at least this many percent more, 1..99.
  std::optional<int> uniqueness_percent = std::nullopt;
  // Winners must cost less than their rivals, which those on a flat surface do not
  // (winner_margin.h).
  bool distinct = false;
  // Mean |Sobel derivative| of the surroundings, in grey levels, 1..127: where it is less the
  // picture is flat; needs a prefilter.
  std::optional<int> min_texture = std::nullopt;
  // Disparities that fewer than so many thousandths of the image share are dropped, 1..1000.
  std::optional<int> histogram_permille = std::nullopt;
  // Connected patches of fewer pixels are dropped.
  std::optional<int> speckle_pixels = std::nullopt;
  Subpixel subpixel = Subpixel::kWhole;
  bool median = false;      // 3x3 median of the disparities
  bool confidence = false;  // Matcher::ratio() and Matcher::weak() are kept

  friend bool operator==(const MatchParams&, const MatchParams&) = default;
};

// The largest block, candidate count and image a Matcher accepts.
inline constexpr int kMaxBlock = 64;
inline constexpr int kMaxDisparities = 256;
inline constexpr int kMaxImageWidth = 4096;    // and height
inline constexpr int kMaxMinDisparity = 1024;  // of either sign

inline constexpr Smoothness kDefaultSmoothness{.small_step = 7, .large_step = 33};
// The largest step for which four paths fit u8 together (search/semi_global_search.h).
inline constexpr int kMaxStep = 36;

// Whether the numbers that every search and check shares are in their ranges.
bool in_ranges(const MatchParams& params) noexcept;

// Whether kBlocks has sums for this block and prefilter.
bool blocks_fit(const MatchParams& params) noexcept;

// Empty ("") when the parameters can be used together, else what cannot and what to do, for a
// message.
const char* problem(const MatchParams& params) noexcept;

// kOk, kInvalidArgument (a value outside its range, or a problem()) or kTooLarge.
Status check(const MatchParams& params, int width, int height) noexcept;

// Whether a Matcher has room for pictures, blocks and candidates of this size.
bool fits(const MatchParams& params, int width, int height) noexcept;

// Parameter sets that need no tuning. `chapter`: the methods of the book chapter by Kuhnert &
// Stommel (2006) as printed.
struct Preset {
  std::string_view name;
  std::string_view meaning;  // one line
  MatchParams params;        // for 64 candidates from 0
};
// A preset for disparities that become depth: fitted to 1/16 px, because whole ones are
// steps in depth, and with the confidence that fusion needs.
MatchParams for_depth(const Preset& preset) noexcept;
// nullptr: no preset of that name.
const Preset* find_preset(std::string_view name) noexcept;
// "fast, quality, chapter", for messages.
std::string_view preset_names() noexcept;

}  // namespace stof::dsp
