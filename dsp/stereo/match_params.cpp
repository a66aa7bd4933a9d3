#include "dsp/stereo/match_params.h"

#include <algorithm>
#include <array>
#include <cstdlib>

namespace stof::dsp {
namespace {

bool in_range(const std::optional<int>& value, int low, int high) noexcept {
  return !value || (*value >= low && *value <= high);
}

bool in_ranges(const MatchParams& params) noexcept {
  const Smoothness smoothness = params.smoothness.value_or(Smoothness{});
  return params.disparities >= 1 && params.block_width >= 1 && params.block_height >= 1 &&
         in_range(params.prefilter_cap, 1, 127) && smoothness.small_step >= 0 &&
         smoothness.large_step >= smoothness.small_step && smoothness.large_step <= kMaxPenalty &&
         smoothness.occlusion >= 0 && smoothness.occlusion <= kMaxPenalty &&
         (params.directions == 2 || params.directions == 4 || params.directions == 5 ||
          params.directions == 8) &&
         in_range(params.band, 0, kMaxDisparities) && in_range(params.pyramid_levels, 1, 2) &&
         in_range(params.left_right_tolerance, 0, kMaxDisparities) &&
         in_range(params.uniqueness_percent, 1, 99) && in_range(params.min_texture, 1, 127) &&
         in_range(params.histogram_permille, 1, 1000) &&
         in_range(params.speckle_pixels, 1, kMaxImageWidth * kMaxImageWidth);
}

// Means of |derivative| that only the rounding of a camera leaves.
constexpr int kFlat = 2;

constexpr MatchParams kFast{.left_right_tolerance = 1,
                            .distinct = true,
                            .min_texture = kFlat,
                            .speckle_pixels = 20,
                            .subpixel = Subpixel::kEquiangular};

constexpr MatchParams kQuality{.cost = Cost::kMixed,
                               .method = Method::kSemiGlobal,
                               .equalise = true,
                               .left_right_tolerance = 1,
                               .distinct = true,
                               .min_texture = kFlat,
                               .speckle_pixels = 100,
                               .median = true};

constexpr MatchParams kChapter{
    .left_right_tolerance = 1, .histogram_permille = 3, .subpixel = Subpixel::kLeastSquares};

constexpr std::array<Preset, 3> kPresets{{
    {"fast", "block matching of derivatives, 1/16 px, every check that costs little", kFast},
    {"quality", "semi-global matching of census and grey over cross-shaped regions, whole px",
     kQuality},
    {"chapter", "16x16 SAD of derivatives, left-right check, histogram, least squares", kChapter},
}};

}  // namespace

const char* problem(const MatchParams& params) noexcept {
  const bool whole_search = params.block_shape != BlockShape::kFixed || params.pyramid_levels;
  const bool by_costs =
      params.subpixel == Subpixel::kEquiangular || params.subpixel == Subpixel::kParabola;
  const bool other_search = params.cost != Cost::kSad || params.method != Method::kWinnerTakesAll;
  if (!in_ranges(params)) {
    return "a value is out of its range: see the help text";
  }
  if ((params.interest || params.min_texture) && !params.prefilter_cap) {
    return "interest operator and texture mask look at the derivative: give a prefilter";
  }
  if (params.interest && params.method != Method::kWinnerTakesAll) {
    return "only winner takes all is for interesting positions: choose method wta";
  }
  if (params.band && params.method != Method::kScanline) {
    return "a band is part of scanline optimisation: choose method so";
  }
  if (params.distinct && (params.interest || params.band)) {
    return "distinctness compares with all candidates, a band and interesting positions leave few: "
           "choose one of the two";
  }
  if (whole_search && (other_search || params.interest)) {
    return "adaptive blocks and coarse to fine are for method wta with cost sad: choose these";
  }
  if (whole_search && (by_costs || params.distinct || params.uniqueness_percent)) {
    return "adaptive blocks and coarse to fine keep no costs for uniqueness, distinctness and fits "
           "of costs: leave these out, or fit by least-squares";
  }
  if (whole_search && params.guided) {
    return "adaptive blocks and coarse to fine keep no costs that a guide could narrow: leave one "
           "of "
           "the two out";
  }
  if (params.block_shape != BlockShape::kFixed && params.pyramid_levels) {
    return "coarse to fine is for fixed blocks: choose one of the two";
  }
  return "";
}

Status check(const MatchParams& params, int width, int height) noexcept {
  if (width < 1 || height < 1 || *problem(params) != '\0') {
    return Status::kInvalidArgument;
  }
  const bool fits = width <= kMaxImageWidth && height <= kMaxImageWidth &&
                    params.disparities <= kMaxDisparities && params.block_width <= kMaxBlock &&
                    params.block_height <= kMaxBlock &&
                    std::abs(params.min_disparity) <= kMaxMinDisparity;
  return fits ? Status::kOk : Status::kTooLarge;
}

Smoothness default_smoothness(Cost cost) noexcept {
  switch (cost) {
    case Cost::kSad:
      return {.small_step = 12, .large_step = 40, .occlusion = 12};
    case Cost::kSsd:
      return {.small_step = 200, .large_step = 800, .occlusion = 200};
    case Cost::kCensus5x5:
      return {.small_step = 6, .large_step = 24, .occlusion = 9};
    case Cost::kCensus9x7:
      return {.small_step = 16, .large_step = 80, .occlusion = 25};
    case Cost::kMixed:
      return {.small_step = 6, .large_step = 32, .occlusion = 16};
  }
  return {};
}

MatchParams method_defaults(Method method) noexcept {
  switch (method) {
    case Method::kWinnerTakesAll:
      return {};
    case Method::kOrdered:
    case Method::kScanline:
    case Method::kSemiGlobal:
      break;
  }
  return {.method = method, .block_width = 5, .block_height = 5};
}

MatchParams for_depth(const Preset& preset) noexcept {
  MatchParams params = preset.params;
  params.confidence = true;
  if (params.subpixel == Subpixel::kWhole) {
    params.subpixel = Subpixel::kEquiangular;
  }
  return params;
}

const Preset* find_preset(std::string_view name) noexcept {
  const auto* const found = std::ranges::find(kPresets, name, &Preset::name);
  return found == kPresets.end() ? nullptr : found;
}

std::string_view preset_names() noexcept { return "fast, quality, chapter"; }

}  // namespace stof::dsp
