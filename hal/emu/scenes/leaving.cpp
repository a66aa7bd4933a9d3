#include "hal/emu/imagery/moving_scene.h"
#include "hal/emu/scenes/materials.h"

namespace stof::hal::emu {
namespace {

using namespace material;

constexpr int kExposures = 12;  // a step
// A door across the left half of the corridor, with its hinge at the wall.
constexpr Vec3 kHinge{-1.1, -1.05, 4.6};
constexpr Vec3 kLeaf{0.55, 1.05, 0.02};  // half of its size

SceneObject box() {
  return {.shape = Shape::kBox,
          .pose = {.position = {-0.3, -0.45, 2.9}},
          .half = {0.3, 0.45, 0.25},
          .material = kCarton};
}

// half_tangent: of the angle by which it is open.
SceneObject door(double half_tangent) {
  Pose pose = turned(half_tangent);
  pose.position = kHinge;
  pose.position = pose.apply({kLeaf.x, 0, 0});
  return {.shape = Shape::kBox, .pose = pose, .half = kLeaf, .material = kDoor};
}

}  // namespace

Motion leaving() {
  constexpr double kClosed = 0;
  constexpr double kOpen = -0.84;  // 80 degrees, away from the camera
  return {.background = empty_corridor(),
          .poses = {{box(), door(kClosed)}, {door(kClosed)}, {door(kOpen)}},
          .exposures_per_pose = kExposures};
}

}  // namespace stof::hal::emu
