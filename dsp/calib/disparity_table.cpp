#include "dsp/calib/disparity_table.h"

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

void fill_disparity_table(const StereoRig& rig, std::int16_t first_raw, std::int16_t sigma_raw,
                          QuarterMm max_range, std::span<DepthInterval> intervals) noexcept {
  STOF_CHECK(!intervals.empty() && sigma_raw >= 0);
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    const double raw = first_raw + static_cast<double>(i);
    const double near = std::max(std::floor(depth_at(rig, raw + 2.0 * sigma_raw)), 1.0);
    const double far = std::ceil(depth_at(rig, raw - 2.0 * sigma_raw));
    if (near >= max_range || i + 1 == intervals.size()) {
      intervals[i] = {};
    } else {
      intervals[i] = {static_cast<QuarterMm>(near),
                      static_cast<QuarterMm>(std::min<double>(far, max_range))};
    }
  }
}

}  // namespace stof::dsp
