#include <utility>

#include "hal/emu/imagery/moving_scene.h"
#include "hal/emu/imagery/phasor.h"
#include "hal/emu/scenes/materials.h"

namespace stof::hal::emu {
namespace {

using namespace material;

constexpr int kPoses = 40;
constexpr int kGaits = 4;  // left and right steps on the way round, 1.3 m each pair
// The way: an ellipse on the floor, past the carton and the column.
constexpr Vec3 kCentre{-0.33, 0, 3.9};
constexpr double kAcross = 0.32;
constexpr double kAlong = 1.25;

// Half tangents of the largest swings: 28 and 22 degrees.
constexpr double kLegSwing = 0.25;
constexpr double kArmSwing = 0.19;

// A person whose frame stands on the floor between the feet and looks along -z.
class Walker {
 public:
  // swing: -1 .. 1, the left leg behind .. ahead.
  Walker(const Pose& pose, double swing) : pose_(pose) {
    for (const double side : {-1.0, 1.0}) {
      leg(side, side * swing * kLegSwing);
      arm(side, -side * swing * kArmSwing);
    }
    const Pose upright;
    add(Shape::kCylinder, upright, {0, -1.18, 0}, {0.205, 0.28, 0.125}, kShirt);
    add(Shape::kEllipsoid, upright, {0, -1.44, 0}, {0.24, 0.07, 0.12}, kShirt);
    add(Shape::kCylinder, upright, {0, -1.53, 0}, {0.055, 0.06, 0.06}, kSkin);
    add(Shape::kEllipsoid, upright, {0, -1.66, 0}, {0.08, 0.12, 0.1}, kSkin);
    add(Shape::kEllipsoid, upright, {0, -1.7, 0.025}, {0.088, 0.1, 0.1}, kHair);
  }

  std::vector<SceneObject> take() { return std::move(objects_); }

 private:
  void add(Shape shape, const Pose& limb, const Vec3& at, const Vec3& half,
           const Material& material) {
    Pose local = limb;
    local.position = limb.apply(at);
    objects_.push_back({.shape = shape, .pose = pose_ * local, .half = half, .material = material});
  }

  void leg(double side, double half_tangent) {
    Pose limb = turned(0, half_tangent);
    limb.position = {0.1 * side, -0.9, 0};
    add(Shape::kEllipsoid, limb, {0, 0.86, -0.05}, {0.05, 0.045, 0.14}, kBlack);
    add(Shape::kCylinder, limb, {0, 0.43, 0}, {0.085, 0.43, 0.095}, kTrousers);
  }

  void arm(double side, double half_tangent) {
    Pose limb = turned(0, half_tangent);
    limb.position = {0.27 * side, -1.42, 0};
    add(Shape::kCylinder, limb, {0, 0.23, 0}, {0.055, 0.25, 0.06}, kShirt);
    add(Shape::kEllipsoid, limb, {0, 0.56, -0.01}, {0.045, 0.1, 0.05}, kSkin);
  }

  Pose pose_;
  std::vector<SceneObject> objects_;
};

}  // namespace

Motion walking() {
  Motion out{.background = empty_corridor(), .poses = {}};
  for (int i = 0; i < kPoses; ++i) {
    const double way = static_cast<double>(i) / kPoses;
    const Phasor at = phasor(way);
    const Vec3 ahead = unit({kAcross * at.re, 0, -kAlong * at.im});
    // About y, so that -z looks ahead.
    Pose pose{{-ahead.z, 0, -ahead.x, 0, 1, 0, ahead.x, 0, -ahead.z}, {}};
    pose.position = kCentre + Vec3{kAcross * at.im, 0, kAlong * at.re};
    out.poses.push_back(Walker(pose, phasor(kGaits * way).im).take());
  }
  return out;
}

}  // namespace stof::hal::emu
