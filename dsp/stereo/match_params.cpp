#include "dsp/stereo/match_params.h"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "dsp/stereo/search/block_winners.h"

namespace stof::dsp {
namespace {

bool in_range(const std::optional<int>& value, int low, int high) noexcept {
  return !value || (*value >= low && *value <= high);
}

// Means of |derivative| that the rounding of a camera leaves of a flat picture.
constexpr int kFlat = 1;

constexpr MatchParams kFast{.block_width = 14,
                            .block_height = 14,
                            .left_right_tolerance = 1,
                            .distinct = true,
                            .min_texture = kFlat,
                            .speckle_pixels = 10,
                            .subpixel = Subpixel::kEquiangular};

constexpr MatchParams kQuality{.search = Search::kSemiGlobal,
                               .equalise = true,
                               .left_right_tolerance = 1,
                               .distinct = true,
                               .min_texture = kFlat,
                               .speckle_pixels = 200,
                               .median = true};

constexpr MatchParams kChapter{
    .left_right_tolerance = 1, .histogram_permille = 3, .subpixel = Subpixel::kLeastSquares};

constexpr std::array<Preset, 3> kPresets{{
    {"fast", "block matching of derivatives, 1/16 px, every check that costs little", kFast},
    {"quality", "semi-global matching of census, grey and derivative, whole px", kQuality},
    {"chapter", "16x16 SAD of derivatives, left-right check, histogram, least squares", kChapter},
}};

}  // namespace

bool in_ranges(const MatchParams& params) noexcept {
  return params.disparities >= 1 && params.block_width >= 1 && params.block_height >= 1 &&
         in_range(params.prefilter_cap, 1, 127) &&
         in_range(params.left_right_tolerance, 0, kMaxDisparities) &&
         in_range(params.uniqueness_percent, 1, 99) && in_range(params.min_texture, 1, 127) &&
         in_range(params.histogram_permille, 1, 1000) &&
         in_range(params.speckle_pixels, 1, kMaxImageWidth * kMaxImageWidth);
}

bool blocks_fit(const MatchParams& params) noexcept {
  return params.prefilter_cap &&
         block_winners_serve(params.block_width, params.block_height, 2 * *params.prefilter_cap);
}

const char* problem(const MatchParams& params) noexcept {
  const Smoothness smoothness = params.smoothness.value_or(kDefaultSmoothness);
  if (!in_ranges(params) || smoothness.small_step < 0 ||
      smoothness.large_step < smoothness.small_step || smoothness.large_step > kMaxStep) {
    return "a value is out of its range: see the help text";
  }
  if (params.min_texture && !params.prefilter_cap) {
    return "the texture mask looks at the derivative: give a prefilter";
  }
  if (params.search == Search::kBlocks && !blocks_fit(params)) {
    return "blocks are matched by derivatives whose sums fit 16 bits: give a prefilter, a smaller "
           "one or a smaller block";
  }
  return "";
}

bool fits(const MatchParams& params, int width, int height) noexcept {
  return width <= kMaxImageWidth && height <= kMaxImageWidth &&
         params.disparities <= kMaxDisparities && params.block_width <= kMaxBlock &&
         params.block_height <= kMaxBlock && std::abs(params.min_disparity) <= kMaxMinDisparity;
}

Status check(const MatchParams& params, int width, int height) noexcept {
  if (width < 1 || height < 1 || *problem(params) != '\0') {
    return Status::kInvalidArgument;
  }
  return fits(params, width, height) ? Status::kOk : Status::kTooLarge;
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
