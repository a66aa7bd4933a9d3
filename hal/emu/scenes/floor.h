#pragma once

#include <cstdint>
#include <vector>

#include "dataset/dataset.h"
#include "hal/emu/scenes/rig.h"
#include "hal/emu/scenes/scene.h"

namespace stof::hal::emu {

// Where the left camera is above the floor, and which floor it is.
struct FloorView {
  double height_m = 0.6;     // kMinFloorHeightM .. kMaxFloorHeightM
  double tilt_degrees = 15;  // downwards, 0 .. kMaxFloorTilt
  std::uint32_t seed = 1;    // of the floor's texture
};
inline constexpr double kMinFloorHeightM = 0.2;
inline constexpr double kMaxFloorHeightM = 1.2;
inline constexpr double kMaxFloorTilt = 30;

// A level floor of weak texture up to a bare wall. Where the camera sees them within 4 m: a pane of
// glass, a box, and on the right an edge behind which the lower floor lies, 10 cm down. Through the
// glass both sensors see what is behind it; the PMD camera also sees the glass, and reads a
// distance between the two.
struct FloorScene {
  Scene scene;
  std::vector<dataset::Surface> surfaces;  // what each object of the scene is
  // 640x480 as corridor_rig(), with 14 bits of the PMD camera. A lower rig has a shorter
  // baseline and less light: both fit a floor at 0.6 m and shrink below that, the light as
  // the square of the height.
  Rig rig;
};
FloorScene floor_scene(const FloorView& view);

}  // namespace stof::hal::emu
