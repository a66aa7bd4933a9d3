#pragma once

#include <array>
#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <string_view>

#include "dataset/dataset.h"
#include "dsp/calib/calibration.h"
#include "hal/emu/scenes/rig.h"

// The flags that make the rig of a rendered scene an imperfect one.
namespace stof::board {

// A pair, and a PMD camera, that are not as they were drawn.
struct Misbuilt {
  std::uint32_t seed = 1;
  double degrees = 2;  // by which the right camera is turned, about an axis of its own
  double rows = 3;     // by which its principal point is lower
};

// yaw, pitch, roll in degrees and x, y, z in metres, from the left camera.
using CameraPlace = std::array<double, 6>;

struct RigOptions {
  std::string name;  // corridor, hall, chapter; empty: the scene's own
  std::optional<Misbuilt> misbuilt;
  std::optional<dsp::Pinhole> left_lens;  // without a size
  std::optional<dsp::Pinhole> right_lens;
  std::optional<dsp::Pinhole> pmd_lens;
  std::optional<CameraPlace> right_place;
  std::optional<CameraPlace> pmd_place;
  hal::emu::LensQuality lenses{};
  double pmd_blur_px = 0;
  std::optional<double> pmd_light;  // share of the PMD camera's light; none: the scene's own
  bool publishes_drawing = false;
  bool rectified = false;  // no flag: the pair that the raw one becomes, and the truth published

  // Any of those that change what the pair is.
  bool changes_pair() const noexcept { return misbuilt || left_lens || right_lens || right_place; }
};

// "FLAG takes WHAT, not "VALUE"; try --help".
std::unexpected<std::string> refuse_value(std::string_view flag, const char* what,
                                          std::string_view value);

// Takes one of the flags of rig_usage(). false: the flag is none of them. A line: its value means
// nothing.
std::expected<bool, std::string> take_rig_flag(std::string_view flag, std::string_view value,
                                               RigOptions& options);
// These flags, one per line, for --help.
std::string_view rig_usage() noexcept;

// The rig that was asked for by name, else `own`.
hal::emu::Rig named_rig(const RigOptions& options, hal::emu::Rig own);
// What the other flags make of a rig of the final size; or a line that says why it is none.
std::expected<hal::emu::Rig, std::string> changed_rig(hal::emu::Rig rig, const RigOptions& options);

// What the rig really is.
dataset::CalibrationTruth truth_of(const hal::emu::Rig& rig);

}  // namespace stof::board
