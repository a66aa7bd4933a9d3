#include "dsp/fusion/unwrap/unwrapper.h"

#include <algorithm>
#include <cmath>

#include "dsp/base/check.h"
#include "dsp/base/units.h"
#include "dsp/fusion/unwrap/period_decision.h"
#include "dsp/fusion/unwrap/period_evidence.h"
#include "dsp/fusion/unwrap/period_maps.h"
#include "dsp/fusion/unwrap/returned_light.h"
#include "dsp/pmd/interval/fill_intervals.h"

namespace stof::dsp {
namespace {

// Quarter mm.
std::uint32_t turn_of(const PmdSensor& sensor) noexcept {
  return static_cast<std::uint32_t>(
      std::lround(sensor.scale * kQuarterMmPerMetre * kLightMetresPerSecond /
                  (2.0 * sensor.tone.modulation.value)));
}

void apply(const PeriodMaps& picture, const PmdMaps& maps) noexcept {
  for (int y = 0; y < picture.height; ++y) {
    const std::span<QuarterMm> distance = maps.distance.row(y);
    const std::span<QuarterMm> sigma = maps.sigma.row(y);
    const std::span<std::uint8_t> flags = maps.flags.row(y);
    const std::size_t first = picture.index(0, y);
    for (std::size_t x = 0; x < distance.size(); ++x) {
      const std::int8_t period = picture.period[first + x];
      if (period == kNoReading) {
        continue;
      }
      const bool told = period >= 0;
      distance[x] = told ? static_cast<QuarterMm>(picture.distance(first + x, period)) : kNoDepth;
      sigma[x] = told ? sigma[x] : QuarterMm{0};
      flags[x] = static_cast<std::uint8_t>(flags[x] | (told ? 0U : unsigned{kPmdWrapped}));
    }
  }
}

// Beside a reading that tells nothing there may be an edge.
void mark_edges(const PmdMaps& maps) noexcept {
  for (int y = 0; y < maps.flags.height(); ++y) {
    const std::span<std::uint8_t> flags = maps.flags.row(y);
    const std::span<const std::uint8_t> above = maps.flags.row_clamped(y - 1);
    const std::span<const std::uint8_t> below = maps.flags.row_clamped(y + 1);
    const std::span<const QuarterMm> distance = maps.distance.row(y);
    int before = 0;
    int here = above[0] | flags[0] | below[0];
    for (std::size_t x = 0; x < flags.size(); ++x) {
      const int after = x + 1 < flags.size() ? above[x + 1] | flags[x + 1] | below[x + 1] : 0;
      const bool beside = ((before | here | after) & kPmdWrapped) != 0 && distance[x] != kNoDepth;
      flags[x] = static_cast<std::uint8_t>(flags[x] | (beside ? unsigned{kPmdEdge} : 0U));
      before = here;
      here = after;
    }
  }
}

}  // namespace

struct Unwrapper::Parts {
  QuarterMm max_range;
  PeriodMaps picture;
  ReturnedLight light;
  PeriodEvidence evidence;
  PeriodDecision decision;
};

bool Unwrapper::needed(const PmdSensor& sensor, const FusionParams& params) noexcept {
  return sensor.lens.width > 0 && sensor.lens.height > 0 && turn_of(sensor) < params.max_range;
}

Unwrapper::Unwrapper(const Calibration& calibration, const FusionParams& params, int min_disparity,
                     int disparities, int width, int height, Arena& arena) noexcept {
  const Pinhole& pmd = calibration.pmd.lens;
  parts_ =
      arena.put(Parts{.max_range = params.max_range,
                      .picture = PeriodMaps(pmd.width, pmd.height, arena),
                      .light = ReturnedLight(calibration.pmd.white_lsb),
                      .evidence = PeriodEvidence(calibration, params, min_disparity, disparities,
                                                 width, height, arena),
                      .decision = PeriodDecision(pmd.width, pmd.height, std::min(pmd.fx, pmd.fy),
                                                 turn_of(calibration.pmd), arena)});
}

void Unwrapper::resolve(const PmdMaps& maps, ImageView<const Disparity> disparity) noexcept {
  PeriodMaps& picture = parts_->picture;
  STOF_CHECK(maps.distance.width() == picture.width && maps.distance.height() == picture.height);
  STOF_CHECK(same_size(maps.sigma, maps.distance) && same_size(maps.amp2, maps.distance) &&
             same_size(maps.flags, maps.distance) && maps.range > 0);
  if (maps.range >= parts_->max_range) {
    refresh_intervals(maps);
    return;
  }
  picture.range = maps.range;
  picture.periods =
      static_cast<int>(std::min<std::uint32_t>(kMaxQuarterMm / maps.range + 1, kMostPeriods));
  parts_->light.start(maps);
  parts_->evidence.collect(maps, disparity, parts_->light, picture);
  parts_->decision.decide(parts_->light, picture);
  apply(picture, maps);
  refresh_intervals(maps);
  mark_edges(maps);
}

}  // namespace stof::dsp
