#include "dsp/pmd/phase/tone.h"

#include <algorithm>

#include "dsp/base/check.h"
#include "dsp/pmd/interval/sigma.h"
#include "dsp/pmd/phase/phase.h"

namespace stof::dsp {
namespace {

SampleRows sample_rows(const PmdSamples& samples, int y) noexcept {
  return {samples[0].row(y), samples[1].row(y), samples[2].row(y), samples[3].row(y)};
}

void measure_exposure(const PmdSamples& samples, int y, const ExposureTables& tables,
                      const ExposureRow& out) noexcept {
  best::phase(sample_rows(samples, y), tables.limits, {out.phase, out.amp2, out.offset, out.flags});
  best::sigma_and_ratio(out.amp2, out.offset, tables.noise, out.sigma, out.ratio);
}

}  // namespace

Tone make_tone(const PmdSensor& sensor, const PmdTone& tone) noexcept {
  const ToneTables tables = tone_tables(sensor, tone);
  return {.tables = tables, .correction = tables.correction};
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

IntegrationQ8 prepare_tone(std::span<const PmdExposure> exposures,
                           std::optional<std::int32_t> temperature_q8, Tone& tone) noexcept {
  tone.correction.global = global_at(tone.tables, temperature_q8);
  const std::span<ExposureTables> all = std::span(tone.exposures).first(exposures.size());
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
    one.limits = limits_at(tone.tables, integration(one));
    one.noise = noise_at(tone.tables, integration(one));
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

void measure_tone(std::span<const PmdExposure> exposures, int y, const Tone& tone,
                  const MergeRows& spare, const ExposureRow& out) noexcept {
  measure_exposure(exposures[tone.exposures[0].index].samples, y, tone.exposures[0], out);
  for (std::size_t k = 1; k < exposures.size(); ++k) {
    const ExposureTables& shorter = tone.exposures[k];
    measure_exposure(exposures[shorter.index].samples, y, shorter, spare.shorter);
    best::merge_exposures(spare.shorter, static_cast<std::uint8_t>(k), shorter.gain_q8, out,
                          spare.taken);
  }
}

}  // namespace stof::dsp
