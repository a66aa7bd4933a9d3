#include "host/calibrate/rig/extrinsics/subpixel_lock.h"

#include <algorithm>
#include <cmath>

namespace stof::host {
namespace {

constexpr double kOnPlane = 4;      // misfits
constexpr double kEnoughPx = 4;     // of disparity, between a wall's ends
constexpr double kEnoughLooks = 8;  // of a part, to say anything of it

}  // namespace

std::size_t SubpixelLock::part_of(const PlaneLook& look) {
  const double part = look.disparity_px - std::floor(look.disparity_px);
  return static_cast<std::size_t>(std::lround(part * kParts)) % kParts;
}

void SubpixelLock::add(const std::vector<PlaneLook>& looks, const SeenPlane& plane) {
  std::vector<const PlaneLook*> on;
  for (const PlaneLook& look : looks) {
    if (std::abs(look.q - plane.m.dot(look.ray)) <= kOnPlane * plane.misfit * look.sigma) {
      on.push_back(&look);
    }
  }
  const auto [least, most] =
      std::ranges::minmax_element(on, {}, [](const PlaneLook* look) { return look->disparity_px; });
  if (on.empty() || (*most)->disparity_px - (*least)->disparity_px < kEnoughPx) {
    return;
  }
  for (const PlaneLook* const look : on) {
    sums_px_[part_of(*look)] += (look->q - plane.m.dot(look->ray)) / look->sigma;
    counts_[part_of(*look)] += 1;
  }
}

std::vector<PlaneLook> SubpixelLock::undone(std::vector<PlaneLook> looks) const {
  std::array<double, kParts> lock{};
  double mean = 0;  // is an offset of the rig's, which calibrating the pair has judged
  for (std::size_t part = 0; part < kParts; ++part) {
    lock[part] = counts_[part] >= kEnoughLooks ? sums_px_[part] / counts_[part] : 0;
    mean += lock[part] / kParts;
  }
  for (PlaneLook& look : looks) {
    look.q -= (lock[part_of(look)] - mean) * look.sigma;
  }
  return looks;
}

}  // namespace stof::host
