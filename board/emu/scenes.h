#pragma once

#include <cstdint>
#include <expected>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "dataset/dataset.h"
#include "dsp/calib/calibration.h"
#include "hal/emu/imagery/imagery.h"
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
  int pmd_every = 1;  // the PMD camera exposes at every so many edges
};

// Takes one of the flags of scene_usage(). false: the flag is none of them. A line: its value
// means nothing.
std::expected<bool, std::string> take_scene_flag(std::string_view flag, std::string_view value,
                                                 SceneOptions& options);

// These flags, one per line, for --help.
std::string_view scene_usage() noexcept;

// A rendered scene before its cameras.
struct SceneWorld {
  std::unique_ptr<hal::emu::Imagery> imagery;
  dsp::Calibration calibration;  // its fixed pattern lives in the imagery
  int disparities = 0;
  bool moves = false;
  // The truth of the chosen exposure: Z in metres in the left view, +inf = nothing there; 255 =
  // seen by both cameras.
  dataset::Image<float> depth;
  dataset::Image<std::uint8_t> visible;
  std::optional<dataset::FloorTruth> floor = std::nullopt;  // of a scene above a floor
};

// Half a second to four seconds at 640x480.
SceneWorld render_world(const SceneOptions& options, std::uint32_t exposure);

}  // namespace stof::board
