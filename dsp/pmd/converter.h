#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "dsp/calib/calibration.h"
#include "dsp/pmd/phase/merge_exposures.h"
#include "dsp/pmd/pmd_maps.h"

namespace stof::dsp {

using PmdSamples = std::array<ImageView<const std::uint16_t>, 4>;

// Four samples and how long each of them collected light.
struct PmdExposure {
  PmdSamples samples;
  IntegrationQ8 integration = kReferenceIntegration;  // not 0
};

inline constexpr std::size_t kMaxPmdExposures = 4;

struct PmdFrame {
  // Exposures of PmdSensor::frequency, one to kMaxPmdExposures, in any order: each pixel takes the
  // longest that is not saturated.
  std::span<const PmdExposure> first;
  // Of PmdSensor::second, alike. Empty where there is no second frequency; if the sensor has one
  // and the frame has not, distances are those of the first frequency alone.
  std::span<const PmdExposure> second{};
  // Of the sensor, 1/256 degree Celsius. None: PmdSensor::reference_c.
  std::optional<std::int32_t> temperature_q8 = std::nullopt;
};

// Samples to distance with an interval, by this sensor's tables: phase (stray light subtracted),
// corrected phase, one turn or two frequencies to a distance, straight line, lights beside the
// lens, sigma, interval. Where something moved while the samples of a frame of one exposure and one
// frequency were taken, phases and sigma account for it (phase/motion_correction.h). Holds its
// buffers, allocates nothing after construction. Every other step is a row kernel of this folder.
class PmdConverter {
 public:
  // Builds the tables; sensor.lens gives the size. problem(calibration) must be empty. Takes about
  // 20 bytes a pixel, 4 more where readings are averaged, 10 more with lights beside the lens, 4
  // more where there is a long_distance. remembers: readings of the frame before count, too
  // (reading_memory.h), until forget_past(); 2 bytes a pixel.
  PmdConverter(const PmdSensor& sensor, Arena& arena, bool remembers = false) noexcept;

  // Samples of the sensor's size. The result is valid until the next call; integration times scale
  // stray and suppressed light.
  const PmdMaps& convert(const PmdFrame& frame) noexcept;
  // The same of one exposure of the first frequency at reference integration time and temperature.
  const PmdMaps& convert(const PmdSamples& samples) noexcept;

  // The same without intervals: low, high and flags that come from neighbours are not there yet.
  // For who changes readings before refresh_intervals() (fill_intervals.h); convert() is both.
  const PmdMaps& measure(const PmdFrame& frame) noexcept;
  void forget_past() noexcept;

 private:
  struct Tables;
  ExposureRow first_row(int y) const noexcept;
  void measure_row(const PmdFrame& frame, int y) noexcept;
  Tables* tables_;
  PmdMaps maps_;
};

}  // namespace stof::dsp
