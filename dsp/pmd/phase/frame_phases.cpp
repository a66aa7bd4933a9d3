#include "dsp/pmd/phase/frame_phases.h"

#include <algorithm>

#include "dsp/base/check.h"
#include "dsp/pmd/interval/sigma.h"
#include "dsp/pmd/phase/phase.h"

namespace stof::dsp {
namespace {

void measure_exposure(const PmdSamples& samples, int y, const ExposureTables& tables,
                      const ExposureRow& out) noexcept {
  best::phase(sample_rows(samples, y), tables.limits, {out.phase, out.amp2, out.offset, out.flags});
  best::sigma_and_ratio(out.amp2, out.offset, tables.noise, out.sigma, out.ratio);
}

}  // namespace

SampleRows sample_rows(const PmdSamples& samples, int y) noexcept {
  return {samples[0].row(y), samples[1].row(y), samples[2].row(y), samples[3].row(y)};
}

FrameTables make_frame_tables(const PmdSensor& sensor, const PmdFrequency& frequency) noexcept {
  const FrequencyTables tables = frequency_tables(sensor, frequency);
  return {.frequency = tables, .correction = tables.correction};
}

void check_exposures(std::span<const PmdExposure> exposures, int width, int height) noexcept {
  STOF_CHECK(!exposures.empty() && exposures.size() <= kMaxPmdExposures);
  for (const PmdExposure& exposure : exposures) {
    STOF_CHECK(exposure.integration > 0);
    for (const ImageView<const std::uint16_t>& plane : exposure.samples) {
      STOF_CHECK(plane.width() == width && plane.height() == height);
    }
  }
}

IntegrationQ8 prepare_frame_tables(std::span<const PmdExposure> exposures,
                                   std::optional<std::int32_t> temperature_q8,
                                   FrameTables& tables) noexcept {
  tables.correction.global = global_at(tables.frequency, temperature_q8);
  const std::span<ExposureTables> all = std::span(tables.exposures).first(exposures.size());
  for (std::size_t k = 0; k < all.size(); ++k) {
    all[k].index = k;
  }
  const auto integration = [&exposures](const ExposureTables& one) {
    return exposures[one.index].integration;
  };
  std::ranges::sort(all, [&integration](const ExposureTables& a, const ExposureTables& b) {
    return integration(a) != integration(b) ? integration(a) > integration(b) : a.index < b.index;
  });
  const IntegrationQ8 longest = integration(all[0]);
  for (ExposureTables& one : all) {
    const unsigned own = integration(one);
    one.limits = limits_at(tables.frequency, integration(one));
    one.noise = noise_at(tables.frequency, integration(one));
    const unsigned gain = (longest * unsigned{kUnchangedQ8} + own / 2) / own;
    one.gain_q8 = static_cast<std::uint16_t>(std::min(gain, 65535U));
  }
  return longest;
}

ExposureRow take_exposure_row(Arena& arena, std::size_t width) noexcept {
  return {.phase = arena.take<Phase>(width),
          .amp2 = arena.take<std::uint16_t>(width),
          .offset = arena.take<std::uint16_t>(width),
          .ratio = arena.take<std::uint8_t>(width),
          .sigma = arena.take<QuarterMm>(width),
          .flags = arena.take<std::uint8_t>(width)};
}

void measure_phases(std::span<const PmdExposure> exposures, int y, const FrameTables& tables,
                    const MergeRows& spare, const ExposureRow& out) noexcept {
  measure_exposure(exposures[tables.exposures[0].index].samples, y, tables.exposures[0], out);
  for (std::size_t k = 1; k < exposures.size(); ++k) {
    const ExposureTables& shorter = tables.exposures[k];
    measure_exposure(exposures[shorter.index].samples, y, shorter, spare.shorter);
    best::merge_exposures(spare.shorter, static_cast<std::uint8_t>(k), shorter.gain_q8, out,
                          spare.taken);
  }
}

}  // namespace stof::dsp
