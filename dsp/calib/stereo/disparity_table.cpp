#include "dsp/calib/stereo/disparity_table.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "dsp/base/check.h"

namespace stof::dsp {
namespace {

// Quarter mm; infinite where the rays do not meet in front of the cameras.
double depth_at(const StereoRig& rig, double raw) noexcept {
  const double parallax = raw / Disparity::kOne + rig.doff_px;
  return parallax > 0 ? kQuarterMmPerMetre * rig.left.fx * rig.baseline_m / parallax
                      : std::numeric_limits<double>::infinity();
}

}  // namespace

DisparityTable make_disparity_table(const StereoRig& rig, std::int16_t first_raw,
                                    QuarterMm max_range, std::span<DepthInterval> bounds) noexcept {
  STOF_CHECK(bounds.size() > 2 * std::size_t{kMostHalfWidth});
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    const double depth = depth_at(rig, first_raw - kMostHalfWidth + static_cast<double>(i));
    bounds[i].low =
        static_cast<QuarterMm>(std::clamp<double>(std::floor(depth), 1, double{kMaxQuarterMm}));
    bounds[i].high = static_cast<QuarterMm>(std::min<double>(std::ceil(depth), max_range));
  }
  return {.first_raw = first_raw, .max_range = max_range, .bounds = bounds};
}

}  // namespace stof::dsp
