#include <cstdio>
#include <filesystem>
#include <limits>

#include "dataset/dataset.h"
#include "hal/emu/rendered.h"

// stof_emu_pair DIR: one exposure of the emulated corridor as a recorded stereo scene in the folder
// DIR, which is made where missing: the pair, its exact disparities, what both cameras see, the
// rig.
namespace stof::board {
namespace {

namespace emu = hal::emu;

constexpr int kBadInput = 2;

dataset::StereoScene expose_corridor() {
  emu::Rig rig = emu::corridor_rig();
  rig.pmd_lens = {};
  emu::RenderedScene rendered(emu::corridor(), rig);
  const emu::Size size = rendered.stereo_size();
  dataset::StereoScene scene;
  scene.name = "corridor";
  scene.left = {size.width, size.height};
  scene.right = {size.width, size.height};
  rendered.left(0, scene.left.view());
  rendered.right(0, scene.right.view());
  scene.ndisp = rendered.disparities();
  scene.visible = rendered.visible();
  scene.rig = rig.stereo;
  scene.truth = rendered.depth();
  for (float& value : scene.truth->pixels) {
    const double disparity =
        rig.stereo.left.fx * rig.stereo.baseline_m / value - rig.stereo.doff_px;
    value = disparity > 0 ? static_cast<float>(disparity) : std::numeric_limits<float>::infinity();
  }
  return scene;
}

int complain(const std::string& line) {
  std::fprintf(stderr, "stof_emu_pair: %s\n", line.c_str());
  return kBadInput;
}

int run(int argc, char** argv) {
  if (argc != 2) {
    return complain("takes one argument, the folder to write the emulated corridor to");
  }
  const std::filesystem::path folder = argv[1];
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!std::filesystem::is_directory(folder, error)) {
    return complain(folder.string() +
                    ": cannot be made a folder: check the path and its permissions");
  }
  const std::expected<void, dataset::Problem> written =
      dataset::write_stereo_scene(folder, expose_corridor());
  return written ? 0 : complain(written.error().message);
}

}  // namespace
}  // namespace stof::board

int main(int argc, char** argv) { return stof::board::run(argc, argv); }
