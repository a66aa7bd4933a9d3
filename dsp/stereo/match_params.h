#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "dsp/base/status.h"

// How a stereo pair is matched. Every field has one meaning; "off" is never a number.
namespace stof::dsp {

// What two pixels differ by. Pictures are grey values or, with a prefilter, their derivative.
enum class Cost : std::uint8_t {
  kSad,        // |L - R|, 0..255
  kSsd,        // (L - R)^2, 0..65025
  kCensus5x5,  // Hamming distance of 24 bits, 0..24
  kCensus9x7,  // Hamming distance of 62 bits, 0..62
  // Census 5x5 and clipped grey differences, averaged over a cross-shaped region of pixels that
  // look alike (cost/mixed.h, cost/cross.h), 0..27. Has neither block nor prefilter.
  kMixed,
};

enum class Method : std::uint8_t {
  kWinnerTakesAll,
  kOrdered,     // dynamic programming with occlusions and the ordering constraint
  kScanline,    // scanline optimisation
  kSemiGlobal,  // the same energy over several directions
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

enum class Subpixel : std::uint8_t {
  kWhole,         // whole disparities
  kEquiangular,   // fit of the costs by two lines of equal slope
  kParabola,      // fit of the costs by a parabola
  kLeastSquares,  // shift of the grey values; what moves by more than half a pixel is dropped
};

// What a change of disparity between neighbours costs, in the units of one pixel's cost (a block of
// n pixels counts n times as much).
struct Smoothness {
  int small_step = 0;  // P1: by one
  int large_step = 0;  // P2: by more; halved and quartered where the grey value changes
  int occlusion = 0;   // kOrdered: a pixel that only one camera sees

  friend bool operator==(const Smoothness&, const Smoothness&) = default;
};

struct MatchParams {
  int min_disparity = 0;  // px, may be negative (toed-in rigs)
  int disparities = 64;   // candidates min .. min + disparities - 1, at least 1
  Cost cost = Cost::kSad;
  Method method = Method::kWinnerTakesAll;
  BlockShape block_shape = BlockShape::kFixed;
  int block_width = 16;   // px, 1..64
  int block_height = 16;  // px, 1..64
  bool equalise = false;  // bring the right picture to the left one's mean and contrast
  bool smooth = false;    // 3x3 binomial, before any derivative
  // Horizontal derivative (Sobel), clipped to +-cap, 1..127: matches pairs whose brightness
  // differs. Without it grey values are matched.
  std::optional<int> prefilter_cap = 15;

  // Of kOrdered, kScanline and kSemiGlobal; without it
  // default_smoothness(cost).
  std::optional<Smoothness> smoothness = std::nullopt;
  int directions = 4;  // of kSemiGlobal: 2, 4, 5 or 8
  // Only interesting positions are matched; needs a prefilter.
  std::optional<Interest> interest = std::nullopt;
  // kScanline searches only this many px to either side of what winner takes all found nearby.
  std::optional<int> band = std::nullopt;
  // Coarse to fine (search/pyramid.h): 1 begins at half size, 2 at a quarter; finer sizes search
  // near what was found, large blocks at every second pixel of every second row.
  std::optional<int> pyramid_levels = std::nullopt;
  // Each match may be given a guide (cost/mask_costs.h): which candidates each pixel may take.
  bool guided = false;

  // Largest difference in px between a match and the match of the match; without it no check.
  std::optional<int> left_right_tolerance = std::nullopt;
  // A rival candidate (not a neighbour) must cost at least this many percent more, 1..99.
  std::optional<int> uniqueness_percent = std::nullopt;
  // Winners must stand out from their rivals, which those on a flat surface do not (distinct.h).
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
  bool fill = false;        // from the background; every filled pixel is marked (Matcher::filled)
  bool confidence = false;  // Matcher::ratio() and Matcher::weak() are kept

  friend bool operator==(const MatchParams&, const MatchParams&) = default;
};

// The largest block, candidate count and image a Matcher accepts.
inline constexpr int kMaxBlock = 64;
inline constexpr int kMaxDisparities = 256;
inline constexpr int kMaxImageWidth = 4096;    // and height
inline constexpr int kMaxMinDisparity = 1024;  // of either sign

inline constexpr int kMaxPenalty = 65535;  // of Smoothness

// Empty ("") when the parameters can be used together, else what cannot and what to do, for a
// message.
const char* problem(const MatchParams& params) noexcept;

// kOk, kInvalidArgument (a value outside its range, or a problem()) or kTooLarge.
Status check(const MatchParams& params, int width, int height) noexcept;

// The same for every scene.
Smoothness default_smoothness(Cost cost) noexcept;

// The block, cost and prefilter that suit a method; dense, without any check.
MatchParams method_defaults(Method method) noexcept;

// Parameter sets that need no tuning. `chapter`: the methods of Kuhnert & Stommel 2006 as printed.
struct Preset {
  std::string_view name;
  std::string_view meaning;  // one line
  MatchParams params;        // for 64 candidates from 0
};
// What a preset means where its disparities become depth: fitted to 1/16 px, because whole ones are
// steps in depth, and with the confidence that fusion needs.
MatchParams for_depth(const Preset& preset) noexcept;
// nullptr: no preset of that name.
const Preset* find_preset(std::string_view name) noexcept;
// "fast, quality, chapter", for messages.
std::string_view preset_names() noexcept;

}  // namespace stof::dsp
