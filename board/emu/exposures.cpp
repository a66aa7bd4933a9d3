#include "board/emu/exposures.h"

#include <utility>

namespace stof::board {

namespace emu = hal::emu;

dataset::StereoScene pictures_of(emu::SensorImagery& imagery, std::uint32_t exposure) {
  const emu::Size size = imagery.stereo_size();
  dataset::StereoScene scene;
  scene.left = {size.width, size.height};
  scene.right = {size.width, size.height};
  imagery.left(exposure, scene.left.view());
  imagery.right(exposure, scene.right.view());
  scene.ndisp = imagery.disparities();
  return scene;
}

dataset::PmdRecording recording_of(emu::SensorImagery& imagery, std::uint32_t exposure,
                                   std::uint32_t frames) {
  const emu::Size size = imagery.pmd_size();
  dataset::PmdRecording out;
  out.calibration = imagery.calibration();
  out.has_rig = true;
  const std::span<const std::int16_t> pattern = out.calibration.pmd.fixed_pattern;
  out.fixed_pattern.assign(pattern.begin(), pattern.end());
  out.calibration.pmd.fixed_pattern = out.fixed_pattern;
  for (std::uint32_t frame = 0; frame < frames; ++frame) {
    dataset::Image<std::uint16_t> planes(size.width, 4 * size.height);
    for (int k = 0; k < 4; ++k) {
      const dsp::ImageView<std::uint16_t> plane(planes.view().row(k * size.height).data(),
                                                size.width, size.height);
      imagery.pmd(exposure + frame, k, plane);
    }
    out.frames.push_back(std::move(planes));
  }
  return out;
}

std::expected<void, dataset::Problem> make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!std::filesystem::is_directory(folder, error)) {
    return std::unexpected(dataset::Problem{
        folder.string() + ": cannot be made a folder: check the path and its permissions"});
  }
  return {};
}

}  // namespace stof::board
