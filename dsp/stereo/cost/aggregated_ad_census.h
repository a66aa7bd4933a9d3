#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "dsp/stereo/cost/ad_census.h"
#include "dsp/stereo/cost/cost_source.h"
#include "dsp/stereo/cost/cross_aggregation.h"
#include "dsp/stereo/cost/pixel_costs.h"
#include "dsp/stereo/match_params.h"

namespace stof::dsp {

// AD-Census (ad_census.h) of two grey pictures, averaged over those of the 3x3 pixels that look
// like the one in the middle (cross_aggregation.h): rows of u8, kNoCost for candidates outside the
// right picture and for unused lanes, all others at most kLargestMeanCost. Keeps sums of the rows
// that a region can reach, no volume.
//
// Larger regions believe that what looks alike lies at one disparity. They help bare walls that
// face the camera and break slanted surfaces into steps (docs/DESIGN.md).
inline constexpr int kAlike = 5;  // grey levels
// A mean counts as so much: four paths of it, with what their steps cost, fit u8.
inline constexpr int kMeanScale = 10;
inline constexpr int kMeanDivisor = 27;
inline constexpr int kLargestMeanCost =
    (kLargestAdCensusCost * kMeanScale + kMeanDivisor / 2) / kMeanDivisor;
static_assert(kLargestAdCensusCost <= kLargestAggregatedInput);

class AggregatedAdCensus final : public CostSource<std::uint8_t> {
 public:
  // Uses the range of disparities of params.
  AggregatedAdCensus(const MatchParams& params, int width, Arena& arena) noexcept;

  // New pictures of equal size, at most the constructor's width.
  void start(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right) noexcept;
  // In order each row of the pictures is looked at once; begins anywhere, with the same result.
  void row(int y, std::span<std::uint8_t> costs) noexcept override;

 private:
  static constexpr int kKept = 3;

  std::size_t width() const noexcept { return static_cast<std::size_t>(left_.width()); }
  std::span<std::uint8_t> sums(int y) const noexcept;
  std::span<std::uint8_t> counts(int y) const noexcept;
  void add_row(int y) noexcept;

  MatchParams params_;
  std::size_t lanes_;
  PixelCosts pixels_;
  ImageView<const std::uint8_t> left_;
  Rows kept_;  // rows that the rings hold

  std::span<std::uint8_t> sums_;    // kKept rows of costs, summed along the row
  std::span<std::uint8_t> counts_;  // kKept rows: of how many pixels
  std::span<std::uint8_t> costs_;   // of single pixels
  std::span<std::uint8_t> joined_;  // with the column before, or with the row above
  std::span<std::uint8_t> below_;   // joined with the row below
  std::span<std::uint8_t> areas_;   // pixels of each column's region
};

}  // namespace stof::dsp
