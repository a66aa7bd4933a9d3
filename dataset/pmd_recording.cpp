#include "dataset/pmd_recording.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "dataset/files/file.h"
#include "dataset/files/json_fields.h"
#include "dataset/files/json_file.h"
#include "dataset/files/pgm.h"
#include "dsp/base/units.h"

namespace stof::dataset {
namespace {

using nlohmann::json;
using Done = std::expected<void, Problem>;

constexpr int kMaxFrames = 65536;
constexpr int kMostApartUs = 1'000'000'000;
constexpr double kMostOfHarmonics = 0.2;  // beyond it several phases are measured as one

// Those that the file has; `to` keeps the others.
template <typename T>
void take_numbers(std::span<const NumberKey<T>> keys, Fields& fields, T& to) {
  for (const NumberKey<T>& number : keys) {
    to.*number.value = fields.number_or(number.key, to.*number.value);
  }
}

dsp::Pinhole lens_from(Fields& fields) {
  const std::span<const NumberKey<dsp::Pinhole>> keys(kLensKeys);
  dsp::Pinhole lens{.width = fields.integer("width", 1, kMaxSide),
                    .height = fields.integer("height", 1, kMaxSide)};
  for (const NumberKey<dsp::Pinhole>& number : keys.first(kNeededLensKeys)) {
    lens.*number.value = fields.number(number.key);
  }
  take_numbers(keys.subspan(kNeededLensKeys), fields, lens);
  return lens;
}

dsp::WigglingTable wiggling_from(Fields& fields) {
  dsp::WigglingTable table{};
  if (fields.has("wiggling")) {
    std::array<double, dsp::kWigglingSteps> steps{};
    fields.numbers("wiggling", steps);
    fields.require(std::ranges::all_of(steps, [](double step) { return std::abs(step) <= 32767; }),
                   "has a \"wiggling\" step beyond half a turn");
    if (fields.wrong().empty()) {
      std::ranges::transform(steps, table.begin(),
                             [](double step) { return static_cast<std::int16_t>(step); });
    }
    return table;
  }
  const double kappa3 = fields.number_or("kappa3", 0);
  const double kappa5 = fields.number_or("kappa5", 0);
  fields.require(std::abs(kappa3) + std::abs(kappa5) < kMostOfHarmonics,
                 "has kappa3 and kappa5 of 0.2 or more together");
  return fields.wrong().empty() ? dsp::wiggling_of_harmonics(kappa3, kappa5) : dsp::WigglingTable{};
}

dsp::PmdFrequency frequency_from(Fields& fields, double usual_ratio) {
  dsp::PmdFrequency frequency;
  frequency.modulation.value =
      static_cast<std::uint32_t>(fields.integer("f_mod_hz", 1, 2'000'000'000));
  frequency.min_modulation_ratio = fields.number_or("min_modulation_ratio", usual_ratio);
  take_numbers<dsp::PmdFrequency>(kFrequencyKeys, fields, frequency);
  frequency.wiggling = wiggling_from(fields);
  return frequency;
}

// Electrons become LSB. A key in LSB counts more than what follows from electrons.
void light_from(Fields& fields, dsp::PmdSensor& sensor) {
  const double gain = fields.number("lsb_e");
  const double exposure = fields.number_or("int_scale", 1);
  sensor.electrons_per_lsb = gain;
  sensor.noise_lsb = fields.number_or("noise_lsb", fields.number("read_e") / gain);
  // What suppression removes is gone from the samples' mean, but its shot noise is not.
  const double suppressed_e =
      fields.number_or("sbi", 0) * fields.number_or("ambient_e", 0) * exposure;
  sensor.suppressed_lsb = fields.number_or("suppressed_lsb", suppressed_e / gain);
  const double white_e = fields.number_or("contrast", 0) * fields.number_or("s1_e", 0) * exposure;
  sensor.white_lsb = fields.number_or("white_lsb", white_e / gain);
  if (fields.has("emitters")) {
    sensor.emitter_count = fields.triples("emitters", sensor.emitters);
  }
}

dsp::PmdSensor sensor_from(Fields& fields, double usual_ratio) {
  dsp::PmdSensor sensor;
  sensor.lens = lens_from(fields);
  sensor.frequency = frequency_from(fields, usual_ratio);
  sensor.phase_falls = fields.integer_or("phase_falls", 0, 1, 0) == 1;
  sensor.dark_lsb = fields.number("dark_lsb");
  sensor.saturation_lsb = fields.integer("sat_lsb", 1, 65535);
  sensor.under_lsb = fields.integer_or("under_lsb", -65536, 65535, sensor.under_lsb);
  sensor.min_amplitude_lsb =
      fields.integer_or("min_amplitude_lsb", 0, 65535, sensor.min_amplitude_lsb);
  sensor.asymmetry_sigmas = fields.number_or("asymmetry_sigmas", sensor.asymmetry_sigmas);
  light_from(fields, sensor);
  if (fields.has("sigma_polynomial")) {
    std::array<double, 3> abc{};
    fields.numbers("sigma_polynomial", abc);
    sensor.sigma_polynomial = {.a = abc[0], .b = abc[1], .c = abc[2]};
  }
  take_numbers<dsp::PmdSensor>(kSensorKeys, fields, sensor);
  return sensor;
}

void rig_from(Fields& fields, const json& stereo, dsp::Calibration& calibration,
              std::string& wrong) {
  fields.numbers("R", calibration.pmd_to_stereo.rotation);
  fields.numbers("T", calibration.pmd_to_stereo.translation_m);
  Fields rig(stereo);
  const double focal = rig.number("f_px");
  calibration.stereo.left = {.width = rig.integer_or("width", 0, kMaxSide, 0),
                             .height = rig.integer_or("height", 0, kMaxSide, 0),
                             .fx = focal,
                             .fy = rig.number_or("fy_px", focal),
                             .cx = rig.number("cx"),
                             .cy = rig.number("cy")};
  calibration.stereo.baseline_m = rig.number("baseline_m");
  calibration.stereo.doff_px = rig.number("doff_px");
  wrong = rig.wrong().empty() ? "" : "\"stereo\" " + rig.wrong();
}

// What the json says about the files beside it.
struct Layout {
  int frames = 1;
  PatternUnit unit = PatternUnit::kEighthMm;
};

Done read_constants(const std::filesystem::path& file, double usual_ratio, PmdRecording& recording,
                    Layout& layout) {
  const Loaded<json> read = read_object(file);
  if (!read) {
    return std::unexpected(read.error());
  }
  constexpr std::string_view kRemedy = "correct the file";
  const json& root = *read;
  Fields fields(root);
  recording.calibration.pmd = sensor_from(fields, usual_ratio);
  layout.frames = fields.integer_or("frames", 1, kMaxFrames, 1);
  recording.after_pair_us =
      fields.integer_or("after_pair_us", -kMostApartUs, kMostApartUs, recording.after_pair_us);
  if (fields.has("fppn_unit")) {
    layout.unit = static_cast<PatternUnit>(fields.word("fppn_unit", kPatternUnits));
  }
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
  if (wrong = problem_of(recording.calibration, recording.has_rig); !wrong.empty()) {
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
Done read_fixed_pattern(const std::filesystem::path& file, PatternUnit unit,
                        PmdRecording& recording) {
  const Loaded<Image<std::uint16_t>> values = read_pgm16(file);
  if (!values) {
    return std::unexpected(values.error());
  }
  dsp::PmdSensor& sensor = recording.calibration.pmd;
  if (values->width != sensor.lens.width || values->height != sensor.lens.height) {
    return refuse(file,
                  "expected " + size_text(sensor.lens.width, sensor.lens.height) + ", found " +
                      size_text(values->width, values->height),
                  "give the fixed pattern of this sensor");
  }
  const double turn_mm =
      dsp::kLightMetresPerSecond * 1000 / (2.0 * sensor.frequency.modulation.value);
  const double steps = unit == PatternUnit::kTurn ? 1 : 65536 / (8 * turn_mm);
  for (const std::uint16_t value : values->pixels) {
    const long units = std::lround((value - 32768) * steps);
    recording.fixed_pattern.push_back(static_cast<std::int16_t>(static_cast<std::uint16_t>(units)));
  }
  sensor.fixed_pattern = recording.fixed_pattern;
  return {};
}

Done find_fixed_pattern(const std::filesystem::path& prefix,
                        const std::optional<std::filesystem::path>& named, PatternUnit unit,
                        PmdRecording& recording) {
  if (named) {
    return read_fixed_pattern(*named, PatternUnit::kEighthMm, recording);
  }
  const dsp::Pinhole& lens = recording.calibration.pmd.lens;
  const std::filesystem::path own = file_of(prefix, "_fppn.pgm");
  const std::filesystem::path common =
      prefix.parent_path() / (size_text(lens.width, lens.height) + "_fppn.pgm");
  for (const std::filesystem::path& file : {own, common}) {
    if (unit != PatternUnit::kNone && is_there(file)) {
      return read_fixed_pattern(file, unit, recording);
    }
  }
  return {};
}

PmdRecording::Samples samples_of(const Image<std::uint16_t>& planes) {
  const int height = planes.height / 4;
  PmdRecording::Samples views;
  for (int k = 0; k < 4; ++k) {
    views[static_cast<std::size_t>(k)] = {planes.view().row(k * height).data(), planes.width,
                                          height};
  }
  return views;
}

}  // namespace

PmdRecording::Samples PmdRecording::samples(std::size_t frame) const {
  return samples_of(frames[frame]);
}

PmdRecording::Samples PmdRecording::second_samples(std::size_t frame) const {
  return samples_of(second_frames[frame]);
}

Loaded<PmdRecording> read_recording(const std::filesystem::path& prefix,
                                    const std::optional<std::filesystem::path>& fixed_pattern,
                                    double usual_ratio) {
  PmdRecording recording;
  Layout layout;
  if (Done read = read_constants(file_of(prefix, ".json"), usual_ratio, recording, layout); !read) {
    return std::unexpected(std::move(read.error()));
  }
  if (Done read = read_samples(file_of(prefix, "_raw.pgm"), layout.frames, recording); !read) {
    return std::unexpected(std::move(read.error()));
  }
  if (Done read = find_fixed_pattern(prefix, fixed_pattern, layout.unit, recording); !read) {
    return std::unexpected(std::move(read.error()));
  }
  return recording;
}

Loaded<PmdRecording> read_pmd(const std::filesystem::path& prefix,
                              const std::optional<std::filesystem::path>& fixed_pattern) {
  return read_recording(prefix, fixed_pattern, dsp::PmdFrequency{}.min_modulation_ratio);
}

}  // namespace stof::dataset
