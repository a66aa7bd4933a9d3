#pragma once

#include "hal/emu/scenes/scene.h"
#include "hal/emu/scenes/vec3.h"

namespace stof::hal::emu {

inline constexpr double kMaxDriveSpeed = 1.5;  // metres a second

// Where a driving robot's camera is after so many seconds; it began at `start`. It drives to and
// fro in 3 s, looks to both sides in 2 s, and shakes over bumps. `speed` is its highest, in metres
// a second, 0 .. kMaxDriveSpeed; with it go its highest turning rate, 40 degrees a second for each
// metre a second, and its bumps, up to 0.4 degrees and 5 mm.
Pose drive(const Pose& start, double speed, double seconds) noexcept;

// The scene moved so that a camera at `from` sees what one at `to` saw of it.
Scene moved(Scene scene, const Pose& from, const Pose& to);

}  // namespace stof::hal::emu
