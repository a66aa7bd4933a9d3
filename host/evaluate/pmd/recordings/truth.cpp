#include "host/evaluate/pmd/recordings/truth.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "dataset/files/file.h"
#include "dataset/files/json_file.h"

namespace stof::host {
namespace {

using nlohmann::json;

constexpr double kAsideM = 0.01;
constexpr double kSpanShare = 3;
constexpr float kSpanM = 0.05F;

std::optional<double> number(const json& root, const char* key) {
  const auto found = root.find(key);
  return found != root.end() && found->is_number() ? std::optional(found->get<double>())
                                                   : std::nullopt;
}

bool lights_aside(const json& root) {
  const auto found = root.find("emitters");
  if (found == root.end() || !found->is_array() || found->empty()) {
    return false;
  }
  double x = 0;
  double y = 0;
  for (const json& light : *found) {
    if (!light.is_array() || light.size() != 3 || !light[0].is_number() || !light[1].is_number()) {
      return false;
    }
    x += light[0].get<double>();
    y += light[1].get<double>();
  }
  return std::hypot(x, y) / static_cast<double>(found->size()) > kAsideM;
}

std::optional<std::array<double, 2>> pair_of(const json& root) {
  const auto found = root.find("pair");
  if (found == root.end() || !found->is_array() || found->size() != 2 || !(*found)[0].is_number() ||
      !(*found)[1].is_number()) {
    return std::nullopt;
  }
  return std::array{(*found)[0].get<double>(), (*found)[1].get<double>()};
}

dataset::Loaded<dataset::Image<float>> read_map(const std::filesystem::path& file, double unit_m,
                                                const dsp::Pinhole& lens) {
  dataset::Image<float> map;
  std::error_code error;
  if (!std::filesystem::exists(file, error)) {
    return map;
  }
  const dataset::Loaded<dataset::Image<std::uint16_t>> values = dataset::read_pgm16(file);
  if (!values) {
    return std::unexpected(values.error());
  }
  if (values->width != lens.width || values->height != lens.height) {
    return dataset::refuse(
        file, "is not of the recording's size " + dataset::size_text(lens.width, lens.height),
        "give the map that belongs to it");
  }
  map = dataset::Image<float>(lens.width, lens.height);
  std::ranges::transform(values->pixels, map.pixels.begin(), [unit_m](std::uint16_t value) {
    return static_cast<float>(value * unit_m);
  });
  return map;
}

}  // namespace

bool PmdSetup::is_of(const dsp::PmdSensor& sensor) const noexcept {
  return width == sensor.lens.width && height == sensor.lens.height &&
         pair.has_value() == sensor.second.has_value() &&
         (modulation_hz == sensor.frequency.modulation.value ||
          (sensor.second && modulation_hz == sensor.second->modulation.value));
}

dataset::Loaded<PmdSetup> read_setup(const std::filesystem::path& prefix) {
  const std::filesystem::path file = dataset::file_of(prefix, ".json");
  const dataset::Loaded<json> read = dataset::read_object(file);
  if (!read) {
    return std::unexpected(read.error());
  }
  const json& root = *read;
  PmdSetup setup{.z_m = number(root, "z_m"),
                 .edge_m = number(root, "x_edge_m"),
                 .pair = pair_of(root),
                 .width = number(root, "width").value_or(0),
                 .height = number(root, "height").value_or(0),
                 .modulation_hz = number(root, "f_mod_hz").value_or(0),
                 .camera = std::nullopt,
                 .exposure = number(root, "int_scale").value_or(1),
                 .lights_aside = lights_aside(root)};
  if (const std::optional<double> camera = number(root, "camera_seed")) {
    setup.camera = std::lround(*camera);
  }
  constexpr double kMetre = 1000;
  const json unit = root.value("gt_unit", json());
  if (unit == "1 mm") {
    setup.truth_unit_m = 1 / kMetre;
  } else if (!unit.is_null() && unit != "1/8 mm") {
    return dataset::refuse(file, "has a \"gt_unit\" that is neither 1/8 mm nor 1 mm",
                           "correct the file");
  }
  return setup;
}

dataset::Loaded<RangeMaps> read_range_maps(const std::filesystem::path& prefix,
                                           const PmdSetup& setup, const dsp::Pinhole& lens) {
  RangeMaps maps;
  for (const auto& [map, ending] : {std::pair{&maps.nearest, "_r_min.pgm"},
                                    {&maps.middle, "_r_med.pgm"},
                                    {&maps.farthest, "_r_max.pgm"}}) {
    dataset::Loaded<dataset::Image<float>> found =
        read_map(dataset::file_of(prefix, ending), setup.truth_unit_m, lens);
    if (!found) {
      return std::unexpected(std::move(found.error()));
    }
    *map = std::move(*found);
  }
  return maps;
}

dataset::Image<std::uint8_t> mixed_pixels(const RangeMaps& maps) {
  constexpr int kReach = 2;
  const int w = maps.nearest.width;
  const int h = maps.nearest.height;
  dataset::Image<std::uint8_t> mixed(w, h);
  const auto span = [&maps, w](int x, int y) {
    const std::size_t i = static_cast<std::size_t>(y * w + x);
    return maps.farthest.pixels[i] - maps.nearest.pixels[i];
  };
  std::vector<float> around;
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      around.clear();
      for (int v = std::max(y - kReach, 0); v <= std::min(y + kReach, h - 1); ++v) {
        for (int u = std::max(x - kReach, 0); u <= std::min(x + kReach, w - 1); ++u) {
          around.push_back(span(u, v));
        }
      }
      const auto quartile = around.begin() + static_cast<std::ptrdiff_t>(around.size() / 4);
      std::ranges::nth_element(around, quartile);
      const bool is_mixed = span(x, y) > kSpanShare * *quartile + kSpanM;
      mixed.pixels[static_cast<std::size_t>(y * w + x)] = is_mixed ? 1 : 0;
    }
  }
  return mixed;
}

std::optional<std::filesystem::path> borrowed_pattern(const std::filesystem::path& prefix,
                                                      const PmdSetup& setup,
                                                      const dsp::Pinhole& lens,
                                                      const PmdSources& sources) {
  std::error_code error;
  const std::filesystem::path common =
      prefix.parent_path() / (dataset::size_text(lens.width, lens.height) + "_fppn.pgm");
  if (!setup.camera || std::filesystem::exists(common, error) ||
      std::filesystem::exists(dataset::file_of(prefix, "_fppn.pgm"), error)) {
    return std::nullopt;
  }
  const auto found =
      sources.patterns.find({dataset::size_text(lens.width, lens.height), *setup.camera});
  return found == sources.patterns.end() ? std::nullopt : std::optional(found->second);
}

dsp::PmdSensor sensor_for(const dsp::PmdSensor& own, double exposure, const PmdSources& sources) {
  if (!sources.calibration) {
    return own;
  }
  dsp::PmdSensor sensor = *sources.calibration;
  if (sensor.lens.width != own.lens.width || sensor.lens.height != own.lens.height ||
      sensor.frequency.modulation.value != own.frequency.modulation.value ||
      own.second.has_value() != sensor.second.has_value()) {
    return own;
  }
  sensor.frequency.stray_i_lsb *= exposure;
  sensor.frequency.stray_q_lsb *= exposure;
  sensor.suppressed_lsb *= exposure;
  sensor.white_lsb *= exposure;
  sensor.emitter_count = own.emitter_count;
  sensor.emitters = own.emitters;
  return sensor;
}

dataset::Loaded<PmdScene> read_pmd_scene(const std::filesystem::path& prefix,
                                         const PmdSources& sources) {
  const dataset::Loaded<PmdSetup> setup = read_setup(prefix);
  if (!setup) {
    return std::unexpected(setup.error());
  }
  dataset::Loaded<dataset::PmdRecording> recording = dataset::read_pmd(prefix);
  if (recording && recording->fixed_pattern.empty()) {
    if (const std::optional<std::filesystem::path> pattern =
            borrowed_pattern(prefix, *setup, recording->calibration.pmd.lens, sources)) {
      recording = dataset::read_pmd(prefix, pattern);
    }
  }
  if (!recording) {
    return std::unexpected(std::move(recording.error()));
  }
  recording->calibration.pmd = sensor_for(recording->calibration.pmd, setup->exposure, sources);
  return PmdScene{
      .name = prefix.filename().string(), .setup = *setup, .recording = std::move(*recording)};
}

}  // namespace stof::host
