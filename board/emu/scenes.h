#pragma once

#include <cstdint>
#include <expected>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

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
  hal::emu::ExposureTimes times;  // of which only pmd_every matters where the rig stands
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

// The scene's truth is not that of another exposure.
bool moves(const SceneOptions& options);
// Its pictures take long to render, each anew: for emulated time.
bool renders_as_it_goes(const SceneOptions& options);

// Half a second to four seconds at 640x480.
SceneWorld render_world(const SceneOptions& options);

}  // namespace stof::board
