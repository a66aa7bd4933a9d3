#pragma once

#include "hal/emu/scenes/scene.h"
#include "hal/emu/scenes/vec3.h"

namespace stof::hal::emu {

// Where the ray meets one form at t > 1e-6, in the thing's frame; t < 0: it does not.
struct LocalHit {
  double t = -1;
  Vec3 normal;  // unit, against the ray
  int face = 0;
};
LocalHit intersect(Form form, const Vec3& half, const Vec3& origin, const Vec3& direction) noexcept;

}  // namespace stof::hal::emu
