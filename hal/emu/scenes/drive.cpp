#include "hal/emu/scenes/drive.h"

#include <numbers>

#include "hal/emu/imagery/phasor.h"

namespace stof::hal::emu {
namespace {

constexpr double kRoundS = 3;  // there and back
constexpr double kLookS = 2;   // to one side and the other
constexpr double kTurnPerMetre = 40;
constexpr double kShakesPerS = 5;
constexpr double kShakeDegrees = 0.4;  // at kMaxDriveSpeed
constexpr double kShakeM = 0.005;

// The highest rate of a sine is 2 pi times its height a period.
double height_of(double rate, double period_s) noexcept {
  return rate * period_s / (2 * std::numbers::pi);
}

}  // namespace

Pose drive(const Pose& start, double speed, double seconds) noexcept {
  const double ahead = height_of(speed, kRoundS) * (1 - phasor(seconds / kRoundS).re);
  const double yaw = height_of(kTurnPerMetre * speed, kLookS) * phasor(seconds / kLookS).im;
  const double shake =
      speed / kMaxDriveSpeed * phasor(kShakesPerS * seconds).im * phasor(seconds).im;
  Pose pose = start * turned(half_tangent(yaw), half_tangent(kShakeDegrees * shake));
  pose.position = pose.position + Vec3{0, kShakeM * shake, ahead};
  return pose;
}

Scene moved(Scene scene, const Pose& from, const Pose& to) {
  const Pose move = from * inverse(to);
  for (SceneObject& object : scene.objects) {
    object.pose = move * object.pose;
  }
  for (Light& light : scene.lights) {
    light.position = move.apply(light.position);
  }
  return scene;
}

}  // namespace stof::hal::emu
