#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "dsp/stereo/cost/ad_census.h"
#include "dsp/stereo/cost/arms.h"
#include "dsp/stereo/cost/cost_source.h"
#include "dsp/stereo/cost/cross_aggregation.h"
#include "dsp/stereo/cost/pixel_costs.h"
#include "dsp/stereo/match_params.h"

namespace stof::dsp {

// AD-Census (ad_census.h) of two grey pictures, averaged over cross-shaped regions of left pixels
// that look alike (cross_aggregation.h): rows of u8, kNoCost for candidates outside the right
// picture and for unused lanes, all others at most kLargestAdCensusCost. Keeps sums of the rows
// that a region can reach, no volume.
inline constexpr ArmParams kCrossArms{.longest = 12, .difference = 10};
static_assert((2 * kCrossArms.longest + 1) * (2 * kCrossArms.longest + 1) * kLargestAdCensusCost <
              65536);

class CrossCosts final : public CostSource<std::uint8_t> {
 public:
  // Of params the range of disparities.
  CrossCosts(const MatchParams& params, int width, Arena& arena) noexcept;

  // New pictures of equal size, at most the constructor's width.
  void start(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right) noexcept;
  // In order each row of the pictures is looked at once; begins anywhere, with the same result.
  void row(int y, std::span<std::uint8_t> costs) noexcept override;

 private:
  static constexpr int kKept = 2 * kCrossArms.longest + 2;

  std::size_t width() const noexcept { return static_cast<std::size_t>(left_.width()); }
  std::span<std::uint16_t> summed(int y) const noexcept;
  std::span<std::uint16_t> areas(int y) const noexcept;
  void add_row(int y) noexcept;
  void vertical_arms(int y, int direction, std::span<std::uint8_t> arms) noexcept;

  MatchParams params_;
  std::size_t lanes_;
  PixelCosts pixels_;
  ImageView<const std::uint8_t> left_;
  Rows kept_;  // rows whose sums the rings hold

  std::span<std::uint16_t> summed_;  // kKept rows of costs, summed down the columns
  std::span<std::uint16_t> areas_;   // kKept rows of pixels, summed down the columns
  std::span<std::uint16_t> sums_;    // along one row
  std::span<std::uint8_t> costs_;    // of single pixels
  std::span<std::uint8_t> before_;   // arms to the left, or upwards
  std::span<std::uint8_t> behind_;
  std::span<CrossEnds> ends_;
};

}  // namespace stof::dsp
