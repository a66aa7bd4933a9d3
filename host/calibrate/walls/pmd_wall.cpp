#include "host/calibrate/walls/pmd_wall.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "dataset/files/file.h"
#include "dataset/files/json_file.h"

namespace stof::host {
namespace {

using nlohmann::json;

constexpr double kFarthestM = 1000;
constexpr double kLongestExposure = 1000;

// A finite number of the document, or NaN.
double number(const json& value) { return value.is_number() ? value.get<double>() : std::nan(""); }

std::string take_setup(const json& root, WallRecording& wall) {
  wall.z_m = number(root.value("z_m", json()));
  if (!(wall.z_m > 0 && wall.z_m < kFarthestM)) {
    return "has a \"z_m\" that is not a distance in metres";
  }
  wall.exposure = number(root.value("int_scale", json(1)));
  if (!(wall.exposure > 0 && wall.exposure < kLongestExposure)) {
    return "has an \"int_scale\" that is not a positive number";
  }
  return {};
}

// Sums over frames of one pixel.
struct Sums {
  std::array<double, 4> sample{};
  std::array<double, 4> squared{};
  double i = 0;
  double i2 = 0;
  double q = 0;
  double q2 = 0;
  bool saturated = false;

  void add(const std::array<double, 4>& a, double limit) noexcept {
    for (std::size_t k = 0; k < a.size(); ++k) {
      sample[k] += a[k];
      squared[k] += a[k] * a[k];
      saturated |= a[k] >= limit;
    }
    const double in = a[0] - a[2];
    const double quad = a[3] - a[1];
    i += in;
    i2 += in * in;
    q += quad;
    q2 += quad * quad;
  }
  Reading reading(int frames, double dark) const noexcept {
    const double n = frames;
    const auto variance = [n](double sum, double sum2) {
      return n < 2 ? 0.0 : std::max(sum2 - sum * sum / n, 0.0) / (n - 1);
    };
    Reading out{.i = i / n, .q = q / n, .saturated = saturated};
    for (std::size_t k = 0; k < sample.size(); ++k) {
      out.level += sample[k] / n / 4;
      out.spread += variance(sample[k], squared[k]) / 4;
    }
    out.level -= dark;
    out.spread_iq = (variance(i, i2) + variance(q, q2)) / 2;
    return out;
  }
};

}  // namespace

const char* to_string(Frames frames) noexcept {
  return kFramesNames[static_cast<std::size_t>(frames)];
}

Frames frames_named(std::string_view name) noexcept {
  for (const Frames frames : {Frames::kEven, Frames::kOdd}) {
    if (name == to_string(frames)) {
      return frames;
    }
  }
  return Frames::kAll;
}

bool chosen(Frames frames, std::size_t frame) noexcept {
  return frames == Frames::kAll || (frame % 2 == 0) == (frames == Frames::kEven);
}

Frames others(Frames frames) noexcept {
  if (frames == Frames::kAll) {
    return frames;
  }
  return frames == Frames::kEven ? Frames::kOdd : Frames::kEven;
}

Wall summarise(const WallRecording& recording, Frames frames) {
  const dsp::PmdSensor& sensor = recording.recording.calibration.pmd;
  const std::size_t pixels =
      static_cast<std::size_t>(sensor.lens.width) * static_cast<std::size_t>(sensor.lens.height);
  std::vector<Sums> sums(pixels);
  Wall wall{
      .name = recording.name, .z_m = recording.z_m, .exposure = recording.exposure, .readings = {}};
  for (std::size_t n = 0; n < recording.recording.frames.size(); ++n) {
    if (!chosen(frames, n)) {
      continue;
    }
    ++wall.frames;
    const std::vector<std::uint16_t>& planes = recording.recording.frames[n].pixels;
    for (std::size_t p = 0; p < pixels; ++p) {
      sums[p].add({static_cast<double>(planes[p]), static_cast<double>(planes[p + pixels]),
                   static_cast<double>(planes[p + 2 * pixels]),
                   static_cast<double>(planes[p + 3 * pixels])},
                  sensor.saturation_lsb);
    }
  }
  if (wall.frames > 0) {
    wall.readings.reserve(pixels);
    for (const Sums& sum : sums) {
      wall.readings.push_back(sum.reading(wall.frames, sensor.dark_lsb));
    }
  }
  return wall;
}

dataset::Loaded<std::vector<std::filesystem::path>> list_walls(
    const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::directory_iterator entry(folder, error);
  if (error) {
    return dataset::refuse(folder, "is not a folder that can be read",
                           "give the folder of the recordings");
  }
  std::vector<std::filesystem::path> prefixes;
  for (; entry != std::filesystem::directory_iterator(); entry.increment(error)) {
    std::filesystem::path file = entry->path();
    if (file.extension() != ".json") {
      continue;
    }
    const dataset::Loaded<json> root = dataset::read_object(file);
    if (!root) {
      return std::unexpected(root.error());
    }
    if (root->contains("z_m")) {
      prefixes.push_back(file.replace_extension());
    }
  }
  if (error) {
    return dataset::refuse(folder, "cannot be read to its end", "check the disk");
  }
  std::ranges::sort(prefixes);
  return prefixes;
}

dataset::Loaded<WallRecording> read_wall(const std::filesystem::path& prefix) {
  dataset::Loaded<dataset::PmdRecording> recording = dataset::read_pmd(prefix);
  if (!recording) {
    return std::unexpected(std::move(recording.error()));
  }
  const std::filesystem::path file = dataset::file_of(prefix, ".json");
  const dataset::Loaded<json> root = dataset::read_object(file);
  if (!root) {
    return std::unexpected(root.error());
  }
  WallRecording wall{.name = prefix.filename().string(), .recording = {}};
  if (const std::string wrong = take_setup(*root, wall); !wrong.empty()) {
    return dataset::refuse(file, wrong, "correct the file");
  }
  const dsp::PmdSensor& told = recording->calibration.pmd;
  dsp::PmdSensor known;
  known.lens = told.lens;
  known.frequency.modulation = told.frequency.modulation;
  known.dark_lsb = told.dark_lsb;
  known.saturation_lsb = told.saturation_lsb;
  known.under_lsb = told.under_lsb;
  known.integration_us = told.integration_us;
  known.emitter_count = told.emitter_count;
  known.emitters = told.emitters;
  recording->calibration.pmd = known;
  wall.recording = std::move(*recording);
  return wall;
}

std::expected<void, dataset::Problem> write_wall(const std::filesystem::path& prefix,
                                                 const WallRecording& wall) {
  if (std::expected<void, dataset::Problem> written = dataset::write_pmd(prefix, wall.recording);
      !written) {
    return written;
  }
  const std::filesystem::path file = dataset::file_of(prefix, ".json");
  dataset::Loaded<json> root = dataset::read_object(file);
  if (!root) {
    return std::unexpected(std::move(root.error()));
  }
  (*root)["z_m"] = wall.z_m;
  (*root)["int_scale"] = wall.exposure;
  return dataset::write_whole(file, root->dump(2) + "\n");
}

std::string mixed(const WallRecording& a, const WallRecording& b) {
  const dsp::PmdSensor& one = a.recording.calibration.pmd;
  const dsp::PmdSensor& two = b.recording.calibration.pmd;
  const dsp::Pinhole& s = one.lens;
  const dsp::Pinhole& t = two.lens;
  if (s.width != t.width || s.height != t.height) {
    return "sizes differ";
  }
  if (s.fx != t.fx || s.fy != t.fy || s.cx != t.cx || s.cy != t.cy || s.k1 != t.k1 ||
      s.k2 != t.k2 || s.k3 != t.k3 || s.p1 != t.p1 || s.p2 != t.p2) {
    return "lenses differ";
  }
  if (one.frequency.modulation.value != two.frequency.modulation.value) {
    return "modulation frequencies differ";
  }
  if (one.dark_lsb != two.dark_lsb || one.saturation_lsb != two.saturation_lsb ||
      one.under_lsb != two.under_lsb) {
    return "dark or saturation levels differ";
  }
  return one.emitter_count == two.emitter_count && one.emitters == two.emitters ? ""
                                                                                : "emitters differ";
}

Middle middle_of(const dsp::Pinhole& lens) noexcept {
  const int width = std::max(lens.width * 3 / 8, 1);
  const int height = std::max(lens.height * 3 / 4, 1);
  const int left = (lens.width - width) / 2;
  const int top = (lens.height - height) / 2;
  return {.left = left, .top = top, .right = left + width, .bottom = top + height};
}

}  // namespace stof::host
