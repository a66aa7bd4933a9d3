#include "dataset/pmd_pair.h"

#include <algorithm>
#include <utility>

#include "dataset/files/file.h"
#include "dataset/files/json_fields.h"

namespace stof::dataset {
namespace {

// Contrast falls with the frequency, and two phases that agree say more than a ratio.
constexpr double kRatioOfTwoFrequencies = 0.25;

// Whether both were taken by one camera.
bool same_camera(const dsp::PmdSensor& a, const dsp::PmdSensor& b) {
  return a.lens.width == b.lens.width && a.lens.height == b.lens.height &&
         std::ranges::all_of(
             kLensKeys, [&](const auto& of) { return a.lens.*of.value == b.lens.*of.value; }) &&
         a.saturation_lsb == b.saturation_lsb && a.phase_falls == b.phase_falls &&
         a.dark_lsb == b.dark_lsb && a.electrons_per_lsb == b.electrons_per_lsb &&
         a.noise_lsb == b.noise_lsb;
}

}  // namespace

Loaded<PmdRecording> read_pmd_pair(const std::filesystem::path& prefix,
                                   const std::filesystem::path& other,
                                   const std::optional<std::filesystem::path>& fixed_pattern) {
  Loaded<PmdRecording> first = read_recording(prefix, fixed_pattern, kRatioOfTwoFrequencies);
  if (!first) {
    return first;
  }
  Loaded<PmdRecording> second = read_recording(other, fixed_pattern, kRatioOfTwoFrequencies);
  if (!second) {
    return second;
  }
  constexpr std::string_view kRemedy = "give two recordings of one camera and one scene";
  const std::filesystem::path second_file = file_of(other, ".json");
  if (!same_camera(first->calibration.pmd, second->calibration.pmd)) {
    return refuse(second_file, "is not of the camera of " + prefix.string(), kRemedy);
  }
  if (first->frames.size() != second->frames.size()) {
    return refuse(second_file, "has not as many frames as " + prefix.string(), kRemedy);
  }
  if (first->calibration.pmd.frequency.modulation.value <
      second->calibration.pmd.frequency.modulation.value) {
    std::swap(first, second);
  }
  first->calibration.pmd.second = second->calibration.pmd.frequency;
  first->second_frames = std::move(second->frames);
  if (const std::string wrong = problem_of(first->calibration, first->has_rig); !wrong.empty()) {
    return refuse(second_file, "does not go with " + prefix.string() + ", " + wrong, kRemedy);
  }
  return first;
}

}  // namespace stof::dataset
