#include "board/emu/write_set.h"

#include <limits>
#include <string>

#include "board/emu/exposures.h"

namespace stof::board {
namespace {

namespace emu = hal::emu;
using Done = std::expected<void, dataset::Problem>;

}  // namespace

Done write_set(const std::filesystem::path& folder, const SceneOptions& options,
               std::uint32_t first, std::uint32_t frames) {
  const BoardWorld world = render_poses(options, static_cast<int>(frames));
  const bool moves = options.board.speed_m_s > 0 || options.board.turn_degrees_s > 0;
  const std::uint32_t round = frames * static_cast<std::uint32_t>(world.truth.poses.size());
  for (std::size_t i = 0; i < world.truth.poses.size(); ++i) {
    // Whole rounds, so that the first exposure shows the first pose; each has noise of its own.
    const std::uint32_t exposure = first * round + frames * static_cast<std::uint32_t>(i);
    const std::filesystem::path to = folder / world.truth.poses[i].folder;
    dataset::StereoScene pair = pictures_of(*world.imagery, exposure);
    pair.name = options.name;
    pair.plane_z_m = world.plane_z_m[i];
    Done written = make_folder(to);
    if (written) {
      written = dataset::write_stereo_scene(to, pair);
    }
    if (written && world.imagery->pmd_size() != emu::Size{}) {
      dataset::PmdRecording recording = recording_of(*world.imagery, exposure, frames);
      recording.has_rig = false;
      if (moves) {
        recording.after_pair_us = after_pair_us(options.times);
      }
      written = dataset::write_pmd(to / "pmd", recording);
    }
    if (!written) {
      return written;
    }
  }
  return dataset::write_calibration_truth(folder / "truth.json", world.truth);
}

Done write_ideal(const std::filesystem::path& folder, const SceneOptions& options,
                 std::uint32_t exposure, std::uint32_t frames) {
  const SceneWorld world = render_ideal(options);
  const std::filesystem::path to = folder / "ideal";
  dataset::StereoScene scene = pictures_of(*world.imagery, exposure);
  const dsp::StereoRig& rig = world.imagery->calibration().stereo;
  scene.name = options.name;
  scene.visible = world.imagery->visible(exposure);
  scene.rig = rig;
  scene.floor = world.floor;
  scene.truth = world.imagery->depth(exposure);
  for (float& value : scene.truth->pixels) {
    const double d = rig.left.fx * rig.baseline_m / double{value} - rig.doff_px;
    value = d > 0 ? static_cast<float>(d) : std::numeric_limits<float>::infinity();
  }
  Done written = make_folder(to);
  if (written) {
    written = dataset::write_stereo_scene(to, scene);
  }
  if (written && world.imagery->pmd_size() != emu::Size{}) {
    written = dataset::write_pmd(to / "pmd", recording_of(*world.imagery, exposure, frames));
  }
  if (!written) {
    return written;
  }
  const std::expected<emu::Rig, std::string> seen = seen_rig(options);
  return seen ? dataset::write_calibration_truth(folder / "truth.json", truth_of(*seen))
              : Done(std::unexpected(dataset::Problem{seen.error()}));
}

}  // namespace stof::board
