#include "hal/emu/scenes/vec3.h"

#include "hal/emu/imagery/phasor.h"

namespace stof::hal::emu {
namespace {

struct SineCosine {
  double sine;
  double cosine;
};

constexpr SineCosine from_half_tangent(double t) noexcept {
  return {2 * t / (1 + t * t), (1 - t * t) / (1 + t * t)};
}

}  // namespace

Pose turned(double yaw_half_tan, double pitch_half_tan, double roll_half_tan) noexcept {
  const SineCosine yaw = from_half_tangent(yaw_half_tan);
  const SineCosine pitch = from_half_tangent(pitch_half_tan);
  const SineCosine roll = from_half_tangent(roll_half_tan);
  const Pose about_y{{yaw.cosine, 0, yaw.sine, 0, 1, 0, -yaw.sine, 0, yaw.cosine}, {}};
  const Pose about_x{{1, 0, 0, 0, pitch.cosine, -pitch.sine, 0, pitch.sine, pitch.cosine}, {}};
  const Pose about_z{{roll.cosine, -roll.sine, 0, roll.sine, roll.cosine, 0, 0, 0, 1}, {}};
  return about_y * about_x * about_z;
}

double half_tangent(double degrees) noexcept {
  const Phasor half = phasor(degrees / 720);
  return half.im / half.re;
}

Pose inverse(const Pose& pose) noexcept {
  const std::array<double, 9>& r = pose.rotation;
  return {.rotation = {r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8]},
          .position = -1 * pose.turn_back(pose.position)};
}

}  // namespace stof::hal::emu
