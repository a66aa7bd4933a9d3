#include "dataset/write_pmd.h"

#include <algorithm>

#include "dataset/files/file.h"
#include "dataset/files/json_fields.h"
#include "dataset/files/pgm.h"

namespace stof::dataset {
namespace {

using nlohmann::ordered_json;
using Done = std::expected<void, Problem>;

template <typename Keys, typename T>
void put_numbers(const Keys& keys, const T& from, ordered_json& root) {
  for (const NumberKey<T>& number : keys) {
    root[number.key] = from.*number.value;
  }
}

void put_lens(const dsp::Pinhole& lens, ordered_json& root) {
  root["width"] = lens.width;
  root["height"] = lens.height;
  put_numbers(kLensKeys, lens, root);
}

void put_frequency(const dsp::PmdFrequency& frequency, ordered_json& root) {
  root["f_mod_hz"] = frequency.modulation.value;
  root["min_modulation_ratio"] = frequency.min_modulation_ratio;
  put_numbers(kFrequencyKeys, frequency, root);
  root["wiggling"] = frequency.wiggling;
}

void put_sensor(const dsp::PmdSensor& sensor, ordered_json& root) {
  put_lens(sensor.lens, root);
  root["phase_falls"] = sensor.phase_falls ? 1 : 0;
  root["dark_lsb"] = sensor.dark_lsb;
  root["sat_lsb"] = sensor.saturation_lsb;
  root["under_lsb"] = sensor.under_lsb;
  root["min_amplitude_lsb"] = sensor.min_amplitude_lsb;
  root["asymmetry_sigmas"] = sensor.asymmetry_sigmas;
  root["lsb_e"] = sensor.electrons_per_lsb;
  root["read_e"] = sensor.noise_lsb * sensor.electrons_per_lsb;
  root["noise_lsb"] = sensor.noise_lsb;  // read_e / lsb_e need not give every bit of it back
  root["suppressed_lsb"] = sensor.suppressed_lsb;
  root["white_lsb"] = sensor.white_lsb;
  if (sensor.sigma_polynomial) {
    const dsp::SigmaPolynomial& sigma = *sensor.sigma_polynomial;
    root["sigma_polynomial"] = {sigma.a, sigma.b, sigma.c};
  }
  put_numbers(kSensorKeys, sensor, root);
  ordered_json& emitters = root["emitters"] = ordered_json::array();
  for (const dsp::Emitter& emitter :
       std::span(sensor.emitters).first(static_cast<std::size_t>(sensor.emitter_count))) {
    emitters.push_back(emitter);
  }
}

void put_rig(const dsp::Calibration& calibration, ordered_json& root) {
  root["R"] = calibration.pmd_to_stereo.rotation;
  root["T"] = calibration.pmd_to_stereo.translation_m;
  const dsp::StereoRig& rig = calibration.stereo;
  root["stereo"] = {
      {"width", rig.left.width},      {"height", rig.left.height}, {"f_px", rig.left.fx},
      {"fy_px", rig.left.fy},         {"cx", rig.left.cx},         {"cy", rig.left.cy},
      {"baseline_m", rig.baseline_m}, {"doff_px", rig.doff_px}};
}

Done judge(const std::filesystem::path& file, const PmdRecording& recording) {
  constexpr std::string_view kRemedy = "write what a camera made";
  const std::string wrong = problem_of(recording.calibration, recording.has_rig);
  if (!wrong.empty()) {
    return refuse(file, wrong, kRemedy);
  }
  const dsp::Pinhole& lens = recording.calibration.pmd.lens;
  const bool fit =
      std::ranges::all_of(recording.frames, [&lens](const Image<std::uint16_t>& frame) {
        return frame.width == lens.width && frame.height == 4 * lens.height;
      });
  if (lens.width < 1 || recording.frames.empty() || !fit) {
    return refuse(file, "there are no frames, or they have not the size of the sensor", kRemedy);
  }
  return {};
}

Image<std::uint16_t> stacked(const std::vector<Image<std::uint16_t>>& frames) {
  Image<std::uint16_t> all(frames.front().width, 0);
  for (const Image<std::uint16_t>& frame : frames) {
    all.height += frame.height;
    all.pixels.insert(all.pixels.end(), frame.pixels.begin(), frame.pixels.end());
  }
  return all;
}

}  // namespace

Done write_pmd(const std::filesystem::path& prefix, const PmdRecording& recording) {
  const dsp::PmdSensor& sensor = recording.calibration.pmd;
  const std::span<const std::int16_t> pattern = sensor.fixed_pattern;
  const std::filesystem::path file = file_of(prefix, ".json");
  if (Done fine = judge(file, recording); !fine) {
    return fine;
  }
  ordered_json root;
  root["frames"] = recording.frames.size();
  if (recording.after_pair_us != 0) {
    root["after_pair_us"] = recording.after_pair_us;
  }
  put_frequency(sensor.frequency, root);
  put_sensor(sensor, root);
  const PatternUnit unit = pattern.empty() ? PatternUnit::kNone : PatternUnit::kTurn;
  root["fppn_unit"] = kPatternUnits[static_cast<std::size_t>(unit)];
  if (recording.has_rig) {
    put_rig(recording.calibration, root);
  }
  if (!pattern.empty()) {
    Image<std::uint16_t> values(sensor.lens.width, sensor.lens.height);
    std::ranges::transform(pattern, values.pixels.begin(), [](std::int16_t value) {
      return static_cast<std::uint16_t>(value + 32768);
    });
    if (Done written = write_pgm16(file_of(prefix, "_fppn.pgm"), values); !written) {
      return written;
    }
  }
  if (Done written = write_pgm16(file_of(prefix, "_raw.pgm"), stacked(recording.frames));
      !written) {
    return written;
  }
  return write_whole(file, root.dump(1) + "\n");
}

}  // namespace stof::dataset
