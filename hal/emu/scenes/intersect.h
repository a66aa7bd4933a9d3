#pragma once

#include "hal/emu/scenes/scene.h"
#include "hal/emu/scenes/vec3.h"

namespace stof::hal::emu {

// Where the ray meets one shape at t > 1e-6, in the object's frame; t < 0: it does not.
struct LocalHit {
  double t = -1;
  Vec3 normal;  // unit, against the ray
  int face = 0;
};
LocalHit intersect(Shape shape, const Vec3& half, const Vec3& origin,
                   const Vec3& direction) noexcept;

}  // namespace stof::hal::emu
