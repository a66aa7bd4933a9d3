#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dataset/dataset.h"

// PMD recordings with what is known about the scene: what the appliance reads by dataset::read_pmd,
// and the truth beside it, which it never sees.
namespace stof::host {

// The fields of PREFIX.json beyond the constants of the camera.
struct PmdSetup {
  std::optional<double> z_m;                  // a wall that faces the camera
  std::optional<double> edge_m;               // x of a board's edge: "x_edge_m"
  std::optional<std::array<double, 2>> pair;  // modulation frequencies, Hz
  double width = 0;                           // pixels
  double height = 0;
  double modulation_hz = 0;
  std::optional<long> camera;  // "camera_seed": recordings of one camera have the same
  double exposure = 1;         // "int_scale": integration time over the reference's
  double truth_unit_m = 1.0 / 8000;
  bool lights_aside = false;  // the middle of the lights is beside the lens by over a centimetre

  // Whether the sensor has the size and a modulation frequency of this recording.
  bool is_of(const dsp::PmdSensor& sensor) const noexcept;
};
dataset::Loaded<PmdSetup> read_setup(const std::filesystem::path& prefix);

// Radial distances inside each pixel, metres. An image that is not there is empty.
struct RangeMaps {
  dataset::Image<float> nearest;   // PREFIX_r_min.pgm
  dataset::Image<float> middle;    // PREFIX_r_med.pgm
  dataset::Image<float> farthest;  // PREFIX_r_max.pgm
};
// One line where a map that is there cannot be read or has another size.
dataset::Loaded<RangeMaps> read_range_maps(const std::filesystem::path& prefix,
                                           const PmdSetup& setup, const dsp::Pinhole& lens);

// Whether two surfaces meet inside a pixel, from `nearest` and `farthest`: its span is more than
// three times that of the surface around it (lower quartile of 5x5) and 5 cm. The rest is the slope
// of one surface.
dataset::Image<std::uint8_t> mixed_pixels(const RangeMaps& maps);

// Where constants come from that a recording does not have itself.
struct PmdSources {
  // Fixed patterns by picture size and camera.
  std::map<std::pair<std::string, long>, std::filesystem::path> patterns;
  // In place of the recordings' own constants where size and modulation are these; lights stay
  // those of the recording. The pattern is borrowed.
  std::optional<dsp::PmdSensor> calibration;
};

struct PmdScene {
  std::string name;
  PmdSetup setup;
  dataset::PmdRecording recording;
};
dataset::Loaded<PmdScene> read_pmd_scene(const std::filesystem::path& prefix,
                                         const PmdSources& sources);
// The pattern for a recording that has none of its own; none where no source has it.
std::optional<std::filesystem::path> borrowed_pattern(const std::filesystem::path& prefix,
                                                      const PmdSetup& setup,
                                                      const dsp::Pinhole& lens,
                                                      const PmdSources& sources);
// The source's constants with this recording's lights, if they are of its kind of camera; else the
// recording's own.
dsp::PmdSensor sensor_for(const dsp::PmdSensor& own, double exposure, const PmdSources& sources);

}  // namespace stof::host
