#include "dsp/fusion/guide/guide_tables.h"

#include <algorithm>
#include <cmath>

#include "dsp/base/check.h"

namespace stof::dsp {
namespace {

// Z = f b / (d + doff), with depths in quarter mm and candidates with a fraction.
class Geometry {
 public:
  Geometry(const StereoRig& rig, int min_disparity) noexcept
      : parallax_(kQuarterMmPerMetre * rig.left.fx * rig.baseline_m),
        offset_(rig.doff_px + min_disparity) {}
  double candidate(double depth) const noexcept { return parallax_ / depth - offset_; }
  // Saturated to the depths that there are.
  double depth(double candidate) const noexcept {
    const double parallax = candidate + offset_;
    return parallax <= parallax_ / kMaxQuarterMm ? kMaxQuarterMm : parallax_ / parallax;
  }

 private:
  double parallax_;
  double offset_;
};

std::int16_t clamped(double candidate) noexcept {
  return static_cast<std::int16_t>(
      std::clamp<double>(candidate, kBeforeCandidates, kBeyondCandidates));
}

}  // namespace

void fill_guide_candidates(const StereoRig& rig, int min_disparity, double margin,
                           std::span<std::int16_t> first, std::span<std::int16_t> last) noexcept {
  STOF_CHECK(first.size() == kGuideDepths && last.size() == kGuideDepths);
  const Geometry geometry(rig, min_disparity);
  for (std::size_t k = 0; k < kGuideDepths; ++k) {
    const double begin = static_cast<double>(k) * kGuideDepthStep;
    const double near = std::max(begin * (1 - margin), 1.0);
    const double far = (begin + kGuideDepthStep) * (1 + margin);
    first[k] = clamped(std::floor(geometry.candidate(far)));
    last[k] = clamped(std::ceil(geometry.candidate(near)));
  }
}

std::size_t fill_guide_distances(const Calibration& calibration, int min_disparity, int disparities,
                                 std::span<QuarterMm> out) noexcept {
  STOF_CHECK(!out.empty());
  const Geometry geometry(calibration.stereo, min_disparity);
  const Pinhole& lens = calibration.pmd.lens;
  const auto& t = calibration.pmd_to_stereo.translation_m;
  const double apart = kQuarterMmPerMetre * std::hypot(t[0], t[1], t[2]);
  constexpr double kObliquest = 1.5;  // distance over Z at the corner of a picture
  constexpr double kClosest = 400;    // 0.1 m
  constexpr double kPixelsPerStep = 2;
  const double first = std::max(geometry.depth(disparities) - apart, kClosest);
  const double last = std::max(kObliquest * geometry.depth(-1) + apart, first);
  const double moves = std::max(lens.fx, lens.fy) * apart * (1 / first - 1 / last);
  const double most = static_cast<double>(out.size());
  const double wanted = std::clamp(std::ceil(moves / kPixelsPerStep) + 1, 1.0, most);
  const std::size_t count = static_cast<std::size_t>(wanted);
  for (std::size_t k = 0; k < count; ++k) {
    const double share = count > 1 ? static_cast<double>(k) / (wanted - 1) : 0;
    const double distance = 1 / ((1 - share) / first + share / last);
    out[k] = static_cast<QuarterMm>(std::min<double>(distance, kMaxQuarterMm));
  }
  return count;
}

}  // namespace stof::dsp
