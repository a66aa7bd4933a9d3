#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include <gtest/gtest.h>

#include "dataset/dataset.h"
#include "dsp/calib/pmd/frequency_pair.h"
#include "dsp/calib/pmd/pmd_tables.h"
#include "dsp/pmd/interval/sigma.h"
#include "dsp/pmd/phase/correct_phase.h"
#include "dsp/pmd/phase/phase.h"
#include "dsp/pmd/pmd_maps.h"
#include "dsp/pmd/range/combine_frequencies.h"
#include "tests/support/recorded_scenes.h"

// Two modulation frequencies on recorded frames, kernel by kernel; where they are, in the folder
// that STOF_DATA names.
namespace stof::dsp {
namespace {

std::filesystem::path recordings() { return test::recorded_scenes() / "tof" / "sim"; }

// A whole frame of one frequency, as one row.
struct FrequencyRow {
  explicit FrequencyRow(std::size_t n)
      : phase(n), corrected(n), amp2(n), offset(n), sigma(n), ratio(n), flags(n) {}

  void measure(const PmdSensor& sensor, const PmdFrequency& frequency,
               const std::vector<std::uint16_t>& planes) {
    const FrequencyTables tables = frequency_tables(sensor, frequency);
    const std::size_t n = phase.size();
    const std::span<const std::uint16_t> all(planes);
    best::phase({all.first(n), all.subspan(n, n), all.subspan(2 * n, n), all.subspan(3 * n, n)},
                limits_at(tables, kReferenceIntegration), {phase, amp2, offset, flags});
    best::sigma_and_ratio(amp2, offset, noise_at(tables, kReferenceIntegration), sigma, ratio);
    best::correct_phase(phase, sensor.fixed_pattern, tables.correction, corrected);
  }
  FrequencyReadings readings() const { return {corrected, amp2, sigma}; }

  std::vector<Phase> phase;
  std::vector<Phase> corrected;
  std::vector<std::uint16_t> amp2;
  std::vector<std::uint16_t> offset;
  std::vector<QuarterMm> sigma;
  std::vector<std::uint8_t> ratio;
  std::vector<std::uint8_t> flags;
};

struct Count {
  int pixels = 0;
  int accepted = 0;
  int wrong = 0;  // of the accepted ones: by half a turn of the first frequency, or more
  std::vector<double> errors_m;
};

Count count_of(const char* name, double min_ratio) {
  Count count;
  const std::filesystem::path dual = recordings() / "dual";
  dataset::Loaded<dataset::PmdRecording> recording =
      dataset::read_pmd_pair(dual / (std::string(name) + "_f0"), dual / (std::string(name) + "_f1"),
                             recordings() / "wall" / "64x16_fppn.pgm");
  const dataset::Loaded<dataset::Image<std::uint16_t>> truth =
      dataset::read_pgm16(dual / (std::string(name) + "_f0_r_med.pgm"));
  EXPECT_TRUE(recording && truth);
  if (!recording || !truth) {
    return count;
  }
  PmdSensor& sensor = recording->calibration.pmd;
  sensor.frequency.min_modulation_ratio = min_ratio;
  sensor.second->min_modulation_ratio = min_ratio;
  const FrequencyPair pair =
      make_frequency_pair(sensor.frequency.modulation, sensor.second->modulation);
  const double turn_m = 299792458.0 / 2 / sensor.frequency.modulation.value;
  const std::size_t n = truth->pixels.size();
  FrequencyRow first(n), second(n);
  std::vector<std::uint32_t> distance(n);
  for (std::size_t k = 0; k < recording->frames.size(); ++k) {
    first.measure(sensor, sensor.frequency, recording->frames[k].pixels);
    second.measure(sensor, *sensor.second, recording->second_frames[k].pixels);
    best::combine_frequencies(first.readings(), second.readings(), pair, second.flags, first.flags,
                              distance);
    for (std::size_t i = 0; i < n; ++i) {
      ++count.pixels;
      if (distance[i] == 0) {
        continue;
      }
      const double range = common_range(pair) / 1e4;
      const double error = std::remainder(distance[i] / 1e4 - truth->pixels[i] / 1e3, range);
      ++count.accepted;
      count.wrong += std::abs(error) > turn_m / 2 ? 1 : 0;
      count.errors_m.push_back(std::abs(error));
    }
  }
  return count;
}

class TwoFrequencies : public test::RecordedScenes {
 protected:
  static void expect(const char* name, double min_ratio, double least_share, double median_m) {
    Count count = count_of(name, min_ratio);
    ASSERT_GT(count.pixels, 0);
    ASSERT_GT(count.accepted, 0);
    EXPECT_EQ(count.wrong, 0) << name;
    const double share = static_cast<double>(count.accepted) / count.pixels;
    EXPECT_GE(share, least_share) << name;
    const auto middle =
        count.errors_m.begin() + static_cast<std::ptrdiff_t>(count.errors_m.size() / 2);
    std::ranges::nth_element(count.errors_m, middle);
    EXPECT_LE(*middle, median_m) << name;
    std::printf("%s MHz, ratio %.2f: %.2f percent accepted, %d wrong, median error %.1f mm\n", name,
                min_ratio, 100 * share, count.wrong, *middle * 1000);
  }
};

TEST_F(TwoFrequencies, OfTwentyMegahertzAreNeverUnwrappedWrongly) {
  expect("20_18.75", 0.25, 0.63, 0.025);
}

TEST_F(TwoFrequencies, OfSixtyMegahertzAreNeverUnwrappedWrongly) {
  expect("60_50", 0.25, 0.59, 0.01);
}

// The noise decides where no ratio does.
TEST_F(TwoFrequencies, AreNotUnwrappedWronglyWithoutAModulationRatioEither) {
  expect("20_18.75", 0, 0.63, 0.025);
  expect("60_50", 0, 0.59, 0.01);
}

}  // namespace
}  // namespace stof::dsp
