#include "dsp/fusion/drift/drift_monitor.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "dsp/base/index.h"
#include "dsp/fusion/drift/disparity_shift.h"
#include "dsp/fusion/drift/plane_reader.h"
#include "dsp/fusion/drift/rig_motion.h"
#include "dsp/fusion/drift/solve_drift.h"

namespace stof::dsp {
namespace {

// Frames until every patch was looked at: a frame then costs half a millisecond.
constexpr int kTurns = 8;
// Five parameters need five equations; fewer than some more are an accident, not a scene.
constexpr std::uint32_t kLeastPatches = 8;
// An observation that lies so many standard deviations and so many pixels from the mean of its
// patch is of something that passes. The mean loses a share of its weight with each; what stays is
// believed after a few more. Chosen; in the corridor, where nothing passes, 2.5 to 100, 0.03 to
// 0.3 px, 1.5 to 6 observations and 0.3 to 0.95 come to the same.
constexpr double kOutlierSigmas = 4;
constexpr double kOutlierPx = 0.1;
constexpr double kLeastKnown = 3;  // observations before one can be an outlier
constexpr double kKeptByOutlier = 0.7;

// Where things move before a patch, it shows one plane after the other. That is no outlier: so far
// off may a drift of these make another plane. Radians, metres, pixels.
constexpr DriftVector kMayDrift{0.0175, 0.0175, 0.0175, 0.05, 0};

// To what is published: micro-radians, 1/16 mm, 1/1000 px.
constexpr DriftVector kUnits{1e6, 1e6, 1e6, 16'000, 1000};

bool is_outlier(const DriftPatch& patch, double error_px, double slack_px) noexcept {
  if (patch.count < kLeastKnown) {
    return false;
  }
  const double sigma = std::sqrt(patch.count / patch.weight());
  return std::abs(error_px - patch.error / patch.weight()) >
         kOutlierSigmas * sigma + kOutlierPx + slack_px;
}

double slack_of(const DriftPatch& patch, const DriftVector& slope) noexcept {
  double sum = 0;
  for (std::size_t k = 0; k < kDriftParameters; ++k) {
    sum += kMayDrift[k] * std::abs(slope[k] - patch.slope[k] / patch.weight());
  }
  return sum;
}

void add_observation(DriftPatch& patch, const ExpectedPlane& plane, const DisparityShift& shift,
                     const Moved& rig) noexcept {
  const double error = shift.px - rig.pitch * plane.slope[0] - rig.yaw * plane.slope[1];
  const double slack = rig.moved && patch.count >= kLeastKnown ? slack_of(patch, plane.slope) : 0;
  if (is_outlier(patch, error, slack)) {
    patch.fade(kKeptByOutlier);
    return;
  }
  double variance = shift.variance + plane.variance;
  for (std::size_t k = 0; k < kDriftParameters; ++k) {
    const double unsure = rig.unsure[k] * plane.slope[k];
    variance += unsure * unsure;
  }
  patch.add(error, plane.slope, variance);
}

}  // namespace

struct DriftMonitor::State {
  DriftParams params;
  double keep = 1;
  PlaneReader reader;
  RigMotion motion;
  // Of frames so far, as they fade: their number, and the sums of Moved::unsure, which no number of
  // frames improves.
  double frames = 0;
  DriftVector unsure{};
  int width = 0;
  int height = 0;
  int columns = 0;
  int rows = 0;
  int turn = 0;
  std::span<DriftPatch> patches;  // row by row
  std::span<double> trust;        // scratch
  std::span<double> sorted;

  void note(const Moved& rig) noexcept {
    frames = keep * frames + 1;
    for (std::size_t k = 0; k < kDriftParameters; ++k) {
      unsure[k] = keep * unsure[k] + rig.unsure[k];
    }
  }
  bool fits(const PmdMaps& maps) const noexcept {
    return maps.distance.width() == width && maps.distance.height() == height &&
           same_size(maps.sigma, maps.distance) && same_size(maps.flags, maps.distance);
  }
};

DriftMonitor::DriftMonitor(const Calibration& calibration, const DriftParams& params,
                           Arena& arena) noexcept {
  const Pinhole& lens = calibration.pmd.lens;
  State s;
  s.params = params;
  s.keep = std::exp(-1 / std::max(params.fade_frames, 1.0));
  s.reader = PlaneReader(calibration, arena);
  s.motion = RigMotion(calibration.stereo.left, arena);
  s.width = lens.width;
  s.height = lens.height;
  s.columns = s.width / s.reader.side();
  s.rows = s.height / s.reader.side();
  const std::size_t count = pixel_count(s.columns, s.rows);
  s.patches = arena.take_filled(count, DriftPatch{});
  s.trust = arena.take<double>(count);
  s.sorted = arena.take<double>(count);
  state_ = arena.put(s);
}

void DriftMonitor::forget() noexcept {
  std::ranges::fill(state_->patches, DriftPatch{});
  state_->motion.forget();
  state_->frames = 0;
  state_->unsure = {};
}

void DriftMonitor::follow(ImageView<const std::uint8_t> left, std::int32_t since_us) noexcept {
  state_->motion.follow(left, since_us);
}

void DriftMonitor::observe(const MatchedPair& pair, const PmdMaps& maps,
                           std::int32_t pmd_lag_us) noexcept {
  State& s = *state_;
  if (s.patches.empty() || !s.fits(maps) || !same_size(pair.left, pair.right) ||
      !same_size(pair.left, pair.disparity)) {
    return;
  }
  const std::optional<Moved> rig = s.motion.during(pmd_lag_us, maps.moved);
  if (!rig) {
    return;
  }
  s.note(*rig);
  for (DriftPatch& patch : s.patches) {
    patch.fade(s.keep);
  }
  const int side = s.reader.side();
  for (int y = 0; y < s.rows; ++y) {
    // Neighbours of both directions in different frames.
    for (int x = (s.turn + 3 * y) % kTurns; x < s.columns; x += kTurns) {
      const std::optional<ExpectedPlane> plane = s.reader.read(x * side, y * side, maps);
      if (!plane) {
        continue;
      }
      if (const std::optional<DisparityShift> shift = disparity_shift(*plane, pair)) {
        add_observation(s.patches[index(y * s.columns + x)], *plane, *shift, *rig);
      }
    }
  }
  s.turn = (s.turn + 1) % kTurns;
}

DriftEstimate DriftMonitor::estimate() const noexcept {
  const State& s = *state_;
  DriftEstimate out;
  out.patches = static_cast<std::uint32_t>(std::ranges::count_if(s.patches, &DriftPatch::known));
  if (out.patches < kLeastPatches) {
    return out;
  }
  const std::optional<DriftSolution> found = solve_drift(
      {.patches = s.patches, .columns = s.columns, .trust = s.trust, .sorted = s.sorted});
  if (!found) {
    return out;
  }
  for (std::size_t k = 0; k < kDriftParameters; ++k) {
    Drift& drift = out.drifts[k];
    const double size = std::abs(found->value[k]);
    const double unsure = s.unsure[k] / s.frames;
    const double sigma = std::sqrt(found->sigma[k] * found->sigma[k] + unsure * unsure);
    drift.value = static_cast<std::int32_t>(std::lround(found->value[k] * kUnits[k]));
    drift.sigma = static_cast<std::int32_t>(std::lround(sigma * kUnits[k]));
    const double bound = s.params.sigmas * sigma;
    const double floor = s.params.floor[k];
    drift.significant = size > bound && size > floor &&
                        (sigma < floor || size * size > floor * floor + bound * bound);
    out.significant = out.significant || drift.significant;
  }
  return out;
}

}  // namespace stof::dsp
