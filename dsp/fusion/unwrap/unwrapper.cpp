#include "dsp/fusion/unwrap/unwrapper.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "dsp/base/units.h"
#include "dsp/fusion/unwrap/decision/wrap_decision.h"
#include "dsp/fusion/unwrap/decision/wrap_memory.h"
#include "dsp/fusion/unwrap/evidence/amplitude_bound.h"
#include "dsp/fusion/unwrap/evidence/wrap_evidence.h"
#include "dsp/fusion/unwrap/wrap_maps.h"
#include "dsp/pmd/interval/fill_intervals.h"

namespace stof::dsp {
namespace {

// Quarter mm.
std::uint32_t turn_of(const PmdSensor& sensor) noexcept {
  return static_cast<std::uint32_t>(
      std::lround(sensor.scale * kQuarterMmPerMetre * kLightMetresPerSecond /
                  (2.0 * sensor.frequency.modulation.value)));
}

void apply(const WrapMaps& maps, const PmdMaps& pmd) noexcept {
  const std::size_t n = index(maps.width);
  const std::uint32_t range = maps.range;
  for (int y = 0; y < maps.height; ++y) {
    const std::span<QuarterMm> distance = pmd.distance.row(y);
    const std::span<QuarterMm> sigma = pmd.sigma.row(y);
    const std::span<std::uint8_t> flags = pmd.flags.row(y);
    const std::span<const std::int8_t> decided = maps.wraps.subspan(maps.place(0, y), n);
    for (std::size_t x = 0; x < n; ++x) {
      const std::int8_t wraps = decided[x];
      if (wraps > 0) {
        distance[x] =
            static_cast<QuarterMm>(distance[x] + static_cast<std::uint32_t>(wraps) * range);
      } else if (wraps < 0 && wraps != kNoReading) {
        if (!pmd.folded.empty()) {
          pmd.folded.row(y)[x] = distance[x];
          pmd.folded_sigma.row(y)[x] = sigma[x];
        }
        distance[x] = kNoDepth;
        sigma[x] = 0;
        flags[x] = static_cast<std::uint8_t>(flags[x] | kPmdWrapped);
      }
    }
  }
}

// Beside a reading that tells nothing there may be an edge. wrapped: of a row, with one more at
// either end, which are 0.
void mark_edges(const PmdMaps& pmd, std::span<std::uint8_t> wrapped) noexcept {
  for (int y = 0; y < pmd.flags.height(); ++y) {
    const std::span<std::uint8_t> flags = pmd.flags.row(y);
    const std::span<const std::uint8_t> above = pmd.flags.row_clamped(y - 1);
    const std::span<const std::uint8_t> below = pmd.flags.row_clamped(y + 1);
    const std::span<const QuarterMm> distance = pmd.distance.row(y);
    for (std::size_t x = 0; x < flags.size(); ++x) {
      wrapped[x + 1] = static_cast<std::uint8_t>((above[x] | flags[x] | below[x]) & kPmdWrapped);
    }
    for (std::size_t x = 0; x < flags.size(); ++x) {
      const int around = wrapped[x] | wrapped[x + 1] | wrapped[x + 2];
      const bool beside = around != 0 && distance[x] != kNoDepth;
      flags[x] = static_cast<std::uint8_t>(flags[x] | (beside ? unsigned{kPmdEdge} : 0U));
    }
  }
}

}  // namespace

struct Unwrapper::Parts {
  QuarterMm max_range;
  WrapMaps maps;
  AmplitudeBound bound;
  WrapEvidence evidence;
  WrapDecision decision;
  std::optional<WrapMemory> memory;
  std::span<std::uint8_t> wrapped;  // for mark_edges()
};

bool Unwrapper::needed(const PmdSensor& sensor, const FusionParams& params) noexcept {
  return sensor.lens.width > 0 && sensor.lens.height > 0 && turn_of(sensor) < params.max_range;
}

Unwrapper::Unwrapper(const Calibration& calibration, const FusionParams& params, int min_disparity,
                     int disparities, int width, int height, Arena& arena,
                     bool remembers) noexcept {
  const Pinhole& pmd = calibration.pmd.lens;
  Parts parts{.max_range = params.max_range,
              .maps = WrapMaps(pmd.width, pmd.height, arena),
              .bound = AmplitudeBound(calibration.pmd.white_lsb),
              .evidence = WrapEvidence(calibration, params, min_disparity, disparities, width,
                                       height, arena),
              .decision = WrapDecision(pmd.width, pmd.height, std::min(pmd.fx, pmd.fy),
                                       turn_of(calibration.pmd), arena),
              .memory = std::nullopt,
              .wrapped = arena.take_filled(index(pmd.width + 2), std::uint8_t{0})};
  if (remembers) {
    parts.memory.emplace(pixel_count(pmd.width, pmd.height), arena);
  }
  parts_ = arena.put(parts);
}

void Unwrapper::forget_past() noexcept {
  if (parts_->memory) {
    parts_->memory->forget();
  }
}

void Unwrapper::resolve(const PmdMaps& pmd, ImageView<const Disparity> disparity) noexcept {
  WrapMaps& maps = parts_->maps;
  STOF_CHECK(pmd.distance.width() == maps.width && pmd.distance.height() == maps.height);
  STOF_CHECK(same_size(pmd.sigma, pmd.distance) && same_size(pmd.amp2, pmd.distance) &&
             same_size(pmd.flags, pmd.distance) && pmd.range > 0);
  if (pmd.range >= parts_->max_range) {
    refresh_intervals(pmd);
    return;
  }
  maps.range = pmd.range;
  maps.wrap_counts =
      static_cast<int>(std::min<std::uint32_t>(kMaxQuarterMm / pmd.range + 1, kMostWrapCounts));
  parts_->bound.start(pmd);
  parts_->evidence.collect(pmd, disparity, parts_->bound, maps);
  parts_->decision.decide(parts_->bound, maps);
  if (parts_->memory) {
    parts_->memory->steady(maps);
  }
  apply(maps, pmd);
  refresh_intervals(pmd);
  mark_edges(pmd, parts_->wrapped);
}

}  // namespace stof::dsp
