#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "dataset/file.h"
#include "dsp/base/units.h"

namespace stof::dataset {
namespace {

using nlohmann::json;
using Done = std::expected<void, Problem>;

constexpr std::size_t kMaxJsonBytes = 1U << 20;
constexpr int kMaxSide = 4096;
constexpr int kMaxFrames = 65536;
constexpr double kMaxWiggleRad = 1;

// Takes numbers out of one JSON document and remembers the first that was missing or wrong.
class Fields {
 public:
  explicit Fields(const json& root) : root_(root) {}

  double number(const char* key) {
    const json::const_iterator at = root_.find(key);
    if (at == root_.end()) {
      return fail(std::string("has no \"") + key + "\"");
    }
    return number_at(*at, key);
  }
  double number_or(const char* key, double fallback) {
    return root_.contains(key) ? number(key) : fallback;
  }
  int integer(const char* key, int low, int high) {
    const double value = number(key);
    if (wrong_.empty() && (value != std::floor(value) || value < low || value > high)) {
      fail(std::string("has a \"") + key + "\" that is not a whole number from " +
           std::to_string(low) + " to " + std::to_string(high));
    }
    return wrong_.empty() ? static_cast<int>(value) : 0;
  }
  // `count` numbers, flat or in rows of arrays.
  void numbers(const char* key, std::span<double> out) {
    std::size_t used = 0;
    const json::const_iterator at = root_.find(key);
    if (at != root_.end() && at->is_array()) {
      for (const json& entry : *at) {
        collect(entry, key, out, used);
      }
    }
    if (used != out.size()) {
      fail(std::string("has no \"") + key + "\" of " + std::to_string(out.size()) + " numbers");
    }
  }
  void require(bool condition, const char* otherwise) {
    if (!condition) {
      fail(otherwise);
    }
  }
  const std::string& wrong() const { return wrong_; }

 private:
  double fail(std::string what) {
    if (wrong_.empty()) {
      wrong_ = std::move(what);
    }
    return 0;
  }
  double number_at(const json& value, const char* key) {
    const double* const real = value.get_ptr<const json::number_float_t*>();
    if (real != nullptr && std::isfinite(*real)) {
      return *real;
    }
    if (const auto* natural = value.get_ptr<const json::number_unsigned_t*>()) {
      return static_cast<double>(*natural);
    }
    if (const auto* integer = value.get_ptr<const json::number_integer_t*>()) {
      return static_cast<double>(*integer);
    }
    return fail(std::string("has a \"") + key + "\" that is not a number");
  }
  void collect(const json& entry, const char* key, std::span<double> out, std::size_t& used) {
    if (entry.is_array()) {
      for (const json& inner : entry) {
        if (used < out.size() && !inner.is_array()) {
          out[used] = number_at(inner, key);
        }
        ++used;
      }
      return;
    }
    if (used < out.size()) {
      out[used] = number_at(entry, key);
    }
    ++used;
  }

  const json& root_;
  std::string wrong_;
};

dsp::PmdSensor sensor_from(Fields& fields) {
  dsp::PmdSensor sensor;
  sensor.lens = {.width = fields.integer("width", 1, kMaxSide),
                 .height = fields.integer("height", 1, kMaxSide),
                 .fx = fields.number("fx"),
                 .fy = fields.number("fy"),
                 .cx = fields.number("cx"),
                 .cy = fields.number("cy"),
                 .k1 = fields.number_or("k1", 0),
                 .k2 = fields.number_or("k2", 0)};
  sensor.tone.modulation.value =
      static_cast<std::uint32_t>(fields.integer("f_mod_hz", 1, 2'000'000'000));
  sensor.dark_lsb = fields.number("dark_lsb");
  sensor.saturation_lsb = fields.integer("sat_lsb", 1, 65535);
  const double gain = fields.number("lsb_e");
  sensor.electrons_per_lsb = gain;
  sensor.noise_lsb = fields.number("read_e") / gain;
  // What suppression removes is gone from the samples' mean, but its shot noise is not.
  sensor.suppressed_lsb = fields.number_or("sbi", 0) * fields.number_or("ambient_e", 0) / gain;
  const double kappa3 = fields.number_or("kappa3", 0);
  const double kappa5 = fields.number_or("kappa5", 0);
  fields.require(std::abs(kappa5 - kappa3) < kMaxWiggleRad, "has kappa3 and kappa5 too far apart");
  sensor.tone.wiggling = dsp::fourth_harmonic_table(fields.wrong().empty() ? kappa5 - kappa3 : 0);
  return sensor;
}

void rig_from(Fields& fields, const json& stereo, dsp::Calibration& calibration,
              std::string& wrong) {
  fields.numbers("R", calibration.pmd_to_stereo.rotation);
  fields.numbers("T", calibration.pmd_to_stereo.translation_m);
  Fields rig(stereo);
  const double focal = rig.number("f_px");
  calibration.stereo.left = {
      .fx = focal, .fy = focal, .cx = rig.number("cx"), .cy = rig.number("cy")};
  calibration.stereo.baseline_m = rig.number("baseline_m");
  calibration.stereo.doff_px = rig.number("doff_px");
  wrong = rig.wrong().empty() ? "" : "\"stereo\" " + rig.wrong();
}

// The numbers must be usable whatever picture they are used with: the left size, which the file
// does not know, and a missing rig are stood in for.
std::string judge(dsp::Calibration calibration, bool has_rig) {
  if (!has_rig) {
    calibration.stereo = {.left = {.fx = 1, .fy = 1}, .baseline_m = 1};
  }
  calibration.stereo.left.width = 1;
  calibration.stereo.left.height = 1;
  return dsp::problem(calibration);
}

Done read_constants(const std::filesystem::path& file, PmdRecording& recording, int& frames) {
  const Loaded<std::string> text = read_whole(file, kMaxJsonBytes);
  if (!text) {
    return std::unexpected(text.error());
  }
  constexpr std::string_view kRemedy = "correct the file";
  const json root = json::parse(*text, nullptr, false);
  if (!root.is_object()) {
    return refuse(file, "is not a JSON object", kRemedy);
  }
  Fields fields(root);
  recording.calibration.pmd = sensor_from(fields);
  frames = root.contains("frames") ? fields.integer("frames", 1, kMaxFrames) : 1;
  std::string wrong;
  recording.has_rig = root.contains("R") || root.contains("T") || root.contains("stereo");
  if (recording.has_rig) {
    if (!root.contains("stereo") || !root["stereo"].is_object()) {
      return refuse(file, "has no object \"stereo\" beside R and T", kRemedy);
    }
    rig_from(fields, root["stereo"], recording.calibration, wrong);
  }
  if (!fields.wrong().empty() || !wrong.empty()) {
    return refuse(file, fields.wrong().empty() ? wrong : fields.wrong(), kRemedy);
  }
  if (wrong = judge(recording.calibration, recording.has_rig); !wrong.empty()) {
    return refuse(file, wrong, kRemedy);
  }
  return {};
}

Done read_samples(const std::filesystem::path& file, int frames, PmdRecording& recording) {
  Loaded<Image<std::uint16_t>> all = read_pgm16(file);
  if (!all) {
    return std::unexpected(std::move(all.error()));
  }
  const dsp::Pinhole& lens = recording.calibration.pmd.lens;
  const std::int64_t rows = std::int64_t{4} * lens.height * frames;
  if (all->width != lens.width || all->height != rows) {
    return refuse(file,
                  "expected " + std::to_string(lens.width) + "x" + std::to_string(rows) + " (" +
                      std::to_string(frames) + " frame(s) of 4 planes of " +
                      size_text(lens.width, lens.height) + ", says the json), found " +
                      size_text(all->width, all->height),
                  "give the samples that belong to this json");
  }
  const std::size_t each =
      4 * static_cast<std::size_t>(lens.width) * static_cast<std::size_t>(lens.height);
  for (std::size_t n = 0; n < static_cast<std::size_t>(frames); ++n) {
    Image<std::uint16_t> frame(lens.width, 4 * lens.height);
    std::copy_n(all->pixels.begin() + static_cast<std::ptrdiff_t>(n * each), each,
                frame.pixels.begin());
    recording.frames.push_back(std::move(frame));
  }
  return {};
}

// (value - 32768) / 8 mm of distance become 1/65536 turns. They wrap, as every phase does.
Done read_fixed_pattern(const std::filesystem::path& file, PmdRecording& recording) {
  if (!is_there(file)) {
    return {};
  }
  const Loaded<Image<std::uint16_t>> values = read_pgm16(file);
  if (!values) {
    return std::unexpected(values.error());
  }
  const dsp::PmdSensor& sensor = recording.calibration.pmd;
  if (values->width != sensor.lens.width || values->height != sensor.lens.height) {
    return refuse(file,
                  "expected " + size_text(sensor.lens.width, sensor.lens.height) + ", found " +
                      size_text(values->width, values->height),
                  "give the fixed pattern of this sensor");
  }
  const double turn_mm = dsp::kLightMetresPerSecond * 1000 / (2.0 * sensor.tone.modulation.value);
  for (const std::uint16_t value : values->pixels) {
    const double offset_mm = (value - 32768) / 8.0;
    const long units = std::lround(offset_mm / turn_mm * 65536);
    recording.fixed_pattern.push_back(static_cast<std::int16_t>(static_cast<std::uint16_t>(units)));
  }
  recording.calibration.pmd.fixed_pattern = recording.fixed_pattern;
  return {};
}

}  // namespace

std::array<dsp::ImageView<const std::uint16_t>, 4> PmdRecording::samples(std::size_t frame) const {
  const Image<std::uint16_t>& planes = frames[frame];
  const int height = planes.height / 4;
  std::array<dsp::ImageView<const std::uint16_t>, 4> views;
  for (int k = 0; k < 4; ++k) {
    views[static_cast<std::size_t>(k)] = {planes.view().row(k * height).data(), planes.width,
                                          height};
  }
  return views;
}

Loaded<PmdRecording> read_pmd(const std::filesystem::path& prefix) {
  std::filesystem::path constants = prefix;
  constants += ".json";
  std::filesystem::path samples = prefix;
  samples += "_raw.pgm";
  PmdRecording recording;
  int frames = 0;
  if (Done read = read_constants(constants, recording, frames); !read) {
    return std::unexpected(std::move(read.error()));
  }
  if (Done read = read_samples(samples, frames, recording); !read) {
    return std::unexpected(std::move(read.error()));
  }
  const dsp::Pinhole& lens = recording.calibration.pmd.lens;
  const std::filesystem::path pattern =
      prefix.parent_path() / (size_text(lens.width, lens.height) + "_fppn.pgm");
  if (Done read = read_fixed_pattern(pattern, recording); !read) {
    return std::unexpected(std::move(read.error()));
  }
  return recording;
}

}  // namespace stof::dataset
