#include "hal/emu/scenes/materials.h"
#include "hal/emu/scenes/scene.h"

namespace stof::hal::emu {
namespace {

using namespace material;

// World: floor y = 0, ceiling y = -2.5, walls x = +-1.15, end wall z = 6.6.
constexpr double kHalfWidth = 1.15;
constexpr double kHeight = 2.5;
constexpr double kEnd = 6.6;
constexpr double kBegin = -1.0;
constexpr double kMiddle = (kBegin + kEnd) / 2;
constexpr double kHalfLength = (kEnd - kBegin) / 2;

void build_shell(Scene& scene) {
  const Pose sideways = turned(kQuarterTurn);
  const Pose level = turned(0, kQuarterTurn);
  const double middle_y = -kHeight / 2;
  add(scene, Shape::kRectangle, {0, 0, kMiddle}, {kHalfWidth, kHalfLength, 0}, kFloor, level);
  add(scene, Shape::kRectangle, {0, -kHeight, kMiddle}, {kHalfWidth, kHalfLength, 0}, kWhite,
      level);
  for (const double side : {-kHalfWidth, kHalfWidth}) {
    add(scene, Shape::kRectangle, {side, middle_y, kMiddle}, {kHalfLength, kHeight / 2, 0}, kWhite,
        sideways);
    add(scene, Shape::kBox, {side, -0.05, kMiddle}, {0.012, 0.05, kHalfLength}, kSkirting);
  }
  add(scene, Shape::kRectangle, {0, middle_y, kEnd}, {kHalfWidth, kHeight / 2, 0}, kWhite);
  add(scene, Shape::kBox, {0, -0.05, kEnd}, {kHalfWidth, 0.05, 0.012}, kSkirting);
}

// A door leaf in its frame on the wall at x = side, from z - 0.45 to z + 0.45.
void build_door(Scene& scene, double side, double z) {
  const double inward = side > 0 ? -1.0 : 1.0;
  add(scene, Shape::kBox, {side, -1.0, z}, {0.015, 1.0, 0.42}, kDoor);
  for (const double edge : {-0.45, 0.45}) {
    add(scene, Shape::kBox, {side, -1.02, z + edge}, {0.035, 1.02, 0.035}, kFrame);
  }
  add(scene, Shape::kBox, {side, -2.04, z}, {0.035, 0.035, 0.485}, kFrame);
  add(scene, Shape::kBox, {side + 0.05 * inward, -1.03, z - 0.36}, {0.035, 0.012, 0.06}, kBlack);
}

void build_furniture(Scene& scene) {
  build_door(scene, -kHalfWidth, 2.95);
  build_door(scene, kHalfWidth, 5.4);
  // The end wall: a dark door, a notice beside it.
  add(scene, Shape::kBox, {-0.35, -1.0, kEnd}, {0.42, 1.0, 0.02}, kDoor);
  for (const double x : {-0.8, 0.1}) {
    add(scene, Shape::kBox, {x, -1.02, kEnd}, {0.035, 1.02, 0.04}, kFrame);
  }
  add(scene, Shape::kBox, {0.5, -1.5, kEnd}, {0.15, 0.21, 0.008}, kPicture);
  // The right wall: a picture in a frame. The left one: a notice board and an extinguisher.
  add(scene, Shape::kBox, {kHalfWidth, -1.55, 3.2}, {0.02, 0.34, 0.44}, kBlack);
  add(scene, Shape::kBox, {kHalfWidth, -1.55, 3.2}, {0.024, 0.3, 0.4}, kPicture);
  add(scene, Shape::kBox, {-kHalfWidth, -1.5, 5.1}, {0.015, 0.3, 0.45}, kPicture);
  add(scene, Shape::kCylinder, {-kHalfWidth + 0.09, -0.75, 4.3}, {0.075, 0.24, 0.075}, kRed);
  // The column.
  add(scene, Shape::kCylinder, {0.62, -kHeight / 2, 4.1}, {0.17, kHeight / 2, 0.17}, kPaint);
}

void build_person(Scene& scene, double x, double z) {
  for (const double side : {-1.0, 1.0}) {
    add(scene, Shape::kEllipsoid, {x + 0.1 * side, -0.04, z - 0.05}, {0.05, 0.045, 0.14}, kBlack);
    add(scene, Shape::kCylinder, {x + 0.1 * side, -0.47, z}, {0.085, 0.43, 0.095}, kTrousers);
    add(scene, Shape::kCylinder, {x + 0.27 * side, -1.19, z}, {0.055, 0.25, 0.06}, kShirt);
    add(scene, Shape::kEllipsoid, {x + 0.27 * side, -0.86, z - 0.01}, {0.045, 0.1, 0.05}, kSkin);
  }
  add(scene, Shape::kCylinder, {x, -1.18, z}, {0.205, 0.28, 0.125}, kShirt);
  add(scene, Shape::kEllipsoid, {x, -1.44, z}, {0.24, 0.07, 0.12}, kShirt);
  add(scene, Shape::kCylinder, {x, -1.53, z}, {0.055, 0.06, 0.06}, kSkin);
  add(scene, Shape::kEllipsoid, {x, -1.66, z}, {0.08, 0.12, 0.1}, kSkin);
  add(scene, Shape::kEllipsoid, {x, -1.7, z + 0.025}, {0.088, 0.1, 0.1}, kHair);
}

void build_carton(Scene& scene, double x, double z) {
  const Pose turn = turned(0.18);  // 20 degrees
  add(scene, Shape::kBox, {x, -0.14, z}, {0.21, 0.14, 0.15}, kCarton, turn);
  add(scene, Shape::kBox, {x, -0.14, z}, {0.025, 0.1405, 0.1505}, kTape, turn);
}

void build_lamps(Scene& scene) {
  // The sign above the far door, mirrored by the floor.
  scene.lights.push_back({.position = {-0.35, -2.25, kEnd - 0.15}, .power = 0.1});
  // Lamps let into the ceiling: they light everything but the ceiling itself.
  for (const double z : {0.5, 2.6, 4.6, 6.1}) {
    scene.lights.push_back({.position = {0, -kHeight - 0.02, z}, .power = 0.55});
  }
}

Scene build(bool with_person) {
  Scene scene;
  scene.ambient = 0.4;
  build_shell(scene);
  build_furniture(scene);
  if (with_person) {
    build_person(scene, -0.42, 3.2);
  }
  build_carton(scene, 0.28, 2.5);
  build_lamps(scene);
  return scene;
}

}  // namespace

Scene corridor() { return build(true); }
Scene empty_corridor() { return build(false); }

}  // namespace stof::hal::emu
