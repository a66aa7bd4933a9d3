#pragma once

#include <cstdint>
#include <expected>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "board/emu/board_scene.h"
#include "board/emu/rig_flags.h"
#include "dataset/dataset.h"
#include "dsp/calib/calibration.h"
#include "hal/emu/imagery/driven_scene.h"
#include "hal/emu/imagery/sensors.h"
#include "hal/emu/scenes/rig.h"

// The rendered scenes by their names, and the flags that say how they are seen: what the emulated
// board and stof_emu_pair have in common.
namespace stof::board {

struct SceneOptions {
  std::string name = "corridor";
  std::optional<hal::emu::Size> size;  // of the stereo pictures; none: the scene's own
  std::optional<hal::emu::Size> pmd;   // 0x0: no PMD camera
  std::optional<std::uint32_t> seed;   // of all noise
  hal::emu::Misplacement misplacement;
  // Of which only pmd_every matters where the rig stands and no board is moved.
  hal::emu::ExposureTimes times;
  RigOptions rig;
  BoardOptions board;
};

// Takes one of the flags of scene_usage(). false: the flag is none of them. A line: its value
// means nothing.
std::expected<bool, std::string> take_scene_flag(std::string_view flag, std::string_view value,
                                                 SceneOptions& options);

// These flags, one per line, for --help.
std::string_view scene_usage() noexcept;

// A rendered scene before its cameras.
struct SceneWorld {
  std::unique_ptr<hal::emu::SensorImagery> imagery;
  std::optional<dataset::FloorTruth> floor = std::nullopt;  // of a scene above a floor
};

// The rig that sees the scene; or a line that says why there is none such, or no such board.
std::expected<hal::emu::Rig, std::string> seen_rig(const SceneOptions& options);

// The scene's truth is not that of another exposure.
bool moves(const SceneOptions& options);
// Its pictures take long to render, each anew: for emulated time.
bool renders_as_it_goes(const SceneOptions& options);

// Half a second to four seconds at 640x480; a board live, a second for each pose and more.
// seen_rig() must have given one.
SceneWorld render_world(const SceneOptions& options);

// The same scene, seen by the pair that the raw pictures of options.rig become once they are
// rectified, with the truth as its calibration.
SceneWorld render_ideal(const SceneOptions& options);

// From the middle of the pair's exposure to that of the PMD camera's.
std::int32_t after_pair_us(const hal::emu::ExposureTimes& times);

// A board as a set of poses, `frames` exposures of each, one after the other. The same holds.
BoardWorld render_poses(const SceneOptions& options, int frames);

}  // namespace stof::board
