#include "dataset/write_pmd.h"

#include <algorithm>

#include "dataset/files/file.h"
#include "dataset/files/json_fields.h"
#include "dataset/files/pgm.h"

namespace stof::dataset {
namespace {

using nlohmann::ordered_json;
using Done = std::expected<void, Problem>;

void put_lens(const dsp::Pinhole& lens, ordered_json& root) {
  root["width"] = lens.width;
  root["height"] = lens.height;
  root["fx"] = lens.fx;
  root["fy"] = lens.fy;
  root["cx"] = lens.cx;
  root["cy"] = lens.cy;
  root["k1"] = lens.k1;
  root["k2"] = lens.k2;
  root["k3"] = lens.k3;
  root["p1"] = lens.p1;
  root["p2"] = lens.p2;
}

void put_frequency(const dsp::PmdFrequency& frequency, ordered_json& root) {
  root["f_mod_hz"] = frequency.modulation.value;
  root["min_modulation_ratio"] = frequency.min_modulation_ratio;
  root["offset_m"] = frequency.offset_m;
  root["offset_m_per_k"] = frequency.offset_m_per_k;
  root["stray_i_lsb"] = frequency.stray_i_lsb;
  root["stray_q_lsb"] = frequency.stray_q_lsb;
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
  root["integration_us"] = sensor.integration_us;
  root["reference_c"] = sensor.reference_c;
  root["scale"] = sensor.scale;
  root["shift_m"] = sensor.shift_m;
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

Done judge(const std::filesystem::path& file, const PmdRecording& recording,
           const std::vector<Image<std::uint16_t>>& frames) {
  constexpr std::string_view kRemedy = "write what a camera made";
  const std::string wrong = problem_of(recording.calibration, recording.has_rig);
  if (!wrong.empty()) {
    return refuse(file, wrong, kRemedy);
  }
  const dsp::Pinhole& lens = recording.calibration.pmd.lens;
  const bool fit = std::ranges::all_of(frames, [&lens](const Image<std::uint16_t>& frame) {
    return frame.width == lens.width && frame.height == 4 * lens.height;
  });
  if (lens.width < 1 || frames.empty() || !fit) {
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

Done write_frequency(const std::filesystem::path& prefix, const PmdRecording& recording,
                     const dsp::PmdFrequency& frequency,
                     const std::vector<Image<std::uint16_t>>& frames,
                     std::span<const std::int16_t> pattern) {
  const std::filesystem::path file = file_of(prefix, ".json");
  if (Done fine = judge(file, recording, frames); !fine) {
    return fine;
  }
  ordered_json root;
  root["frames"] = frames.size();
  put_frequency(frequency, root);
  put_sensor(recording.calibration.pmd, root);
  const PatternUnit unit = pattern.empty() ? PatternUnit::kNone : PatternUnit::kTurn;
  root["fppn_unit"] = kPatternUnits[static_cast<std::size_t>(unit)];
  if (recording.has_rig) {
    put_rig(recording.calibration, root);
  }
  if (!pattern.empty()) {
    const dsp::Pinhole& lens = recording.calibration.pmd.lens;
    Image<std::uint16_t> values(lens.width, lens.height);
    std::ranges::transform(pattern, values.pixels.begin(), [](std::int16_t value) {
      return static_cast<std::uint16_t>(value + 32768);
    });
    if (Done written = write_pgm16(file_of(prefix, "_fppn.pgm"), values); !written) {
      return written;
    }
  }
  if (Done written = write_pgm16(file_of(prefix, "_raw.pgm"), stacked(frames)); !written) {
    return written;
  }
  return write_whole(file, root.dump(1) + "\n");
}

// The same distances as turns of another frequency.
std::vector<std::int16_t> in_turns_of(const dsp::PmdFrequency& other,
                                      const dsp::PmdSensor& sensor) {
  const double ratio =
      static_cast<double>(other.modulation.value) / sensor.frequency.modulation.value;
  std::vector<std::int16_t> pattern(sensor.fixed_pattern.size());
  std::ranges::transform(sensor.fixed_pattern, pattern.begin(), [ratio](std::int16_t value) {
    return static_cast<std::int16_t>(std::lround(value * ratio));
  });
  return pattern;
}

}  // namespace

Done write_pmd(const std::filesystem::path& prefix, const PmdRecording& recording) {
  const dsp::PmdSensor& sensor = recording.calibration.pmd;
  return write_frequency(prefix, recording, sensor.frequency, recording.frames,
                         sensor.fixed_pattern);
}

Done write_pmd_pair(const std::filesystem::path& prefix, const std::filesystem::path& other,
                    const PmdRecording& recording) {
  const dsp::PmdSensor& sensor = recording.calibration.pmd;
  if (!sensor.second || recording.frames.size() != recording.second_frames.size()) {
    return refuse(file_of(other, ".json"), "there is no second frequency, or not as many frames",
                  "write what a camera made");
  }
  if (Done written = write_pmd(prefix, recording); !written) {
    return written;
  }
  return write_frequency(other, recording, *sensor.second, recording.second_frames,
                         in_turns_of(*sensor.second, sensor));
}

}  // namespace stof::dataset
