#include "host/evaluate/pmd/frequencies.h"

#include <algorithm>
#include <cmath>

#include "dataset/files/file.h"
#include "dsp/base/units.h"
#include "host/evaluate/owning_converter.h"
#include "host/evaluate/stereo/median.h"

namespace stof::host {
namespace {

constexpr double kMinRatio = 0.25;
constexpr double kUnitsPerMetre = 1e4;  // PmdMaps::long_distance
constexpr double kMega = 1e6;

struct Judged {
  FrequencyRow row;
  std::vector<double> errors_m;

  void judge(const dsp::PmdMaps& maps, const dataset::Image<float>& truth, double turn_m) {
    row.period_m = static_cast<double>(maps.range) / dsp::kQuarterMmPerMetre;
    for (int y = 0; y < truth.height; ++y) {
      for (int x = 0; x < truth.width; ++x) {
        const double true_m = truth.view().at(x, y);
        const std::uint32_t reading = maps.long_distance.at(x, y);
        if (!(true_m > 0)) {
          continue;
        }
        ++row.pixels;
        if (reading == 0) {
          continue;
        }
        ++row.accepted;
        const double error = std::remainder(reading / kUnitsPerMetre - true_m, row.period_m);
        row.wrong += std::abs(error) >= turn_m / 2 ? 1 : 0;
        errors_m.push_back(std::abs(error));
      }
    }
  }
};

dataset::Loaded<FrequencyRow> judge_pair(const std::filesystem::path& first,
                                         const std::filesystem::path& second,
                                         const PmdSources& sources) {
  const dataset::Loaded<PmdSetup> setup = read_setup(first);
  if (!setup) {
    return std::unexpected(setup.error());
  }
  dataset::Loaded<dataset::PmdRecording> recording = dataset::read_pmd_pair(first, second);
  if (recording && recording->fixed_pattern.empty()) {
    if (const std::optional<std::filesystem::path> pattern =
            borrowed_pattern(first, *setup, recording->calibration.pmd.lens, sources)) {
      recording = dataset::read_pmd_pair(first, second, pattern);
    }
  }
  if (!recording) {
    return std::unexpected(std::move(recording.error()));
  }
  dsp::PmdSensor sensor = sensor_for(recording->calibration.pmd, setup->exposure, sources);
  sensor.frequency.min_modulation_ratio = kMinRatio;
  sensor.second->min_modulation_ratio = kMinRatio;
  const dataset::Loaded<RangeMaps> maps = read_range_maps(first, *setup, sensor.lens);
  if (!maps) {
    return std::unexpected(maps.error());
  }
  if (maps->middle.pixels.empty()) {
    return dataset::refuse(first.string() + "_r_med.pgm: is absent: give the recording's truth");
  }
  const auto [nearest, farthest] = std::ranges::minmax(maps->middle.pixels);
  Judged judged{.row = {.name = first.filename().string() + " + " + second.filename().string(),
                        .first_mhz = sensor.frequency.modulation.value / kMega,
                        .second_mhz = sensor.second->modulation.value / kMega,
                        .nearest_m = nearest,
                        .farthest_m = farthest,
                        .min_ratio = kMinRatio},
                .errors_m = {}};
  const double turn_m = dsp::kLightMetresPerSecond / (2.0 * sensor.frequency.modulation.value);
  OwningConverter converter(sensor);
  for (std::size_t n = 0; n < recording->frames.size(); ++n) {
    const dsp::PmdExposure one{.samples = recording->samples(n)};
    const dsp::PmdExposure two{.samples = recording->second_samples(n)};
    judged.judge(converter->convert({.first = {&one, 1}, .second = {&two, 1}}), maps->middle,
                 turn_m);
  }
  judged.row.median_error_m = median(std::move(judged.errors_m)).value_or(std::nan(""));
  return judged.row;
}

}  // namespace

dataset::Loaded<FrequencyStudy> study_frequencies(const PmdSet& set, const PmdSources& sources) {
  FrequencyStudy study{.folder = set.folder, .rows = {}};
  for (std::size_t n = 0; n + 1 < set.prefixes.size(); n += 2) {
    dataset::Loaded<FrequencyRow> row = judge_pair(set.prefixes[n], set.prefixes[n + 1], sources);
    if (!row) {
      return std::unexpected(std::move(row.error()));
    }
    study.rows.push_back(std::move(*row));
  }
  return study;
}

}  // namespace stof::host
