#include "hal/emu/scenes/room.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "hal/emu/imagery/noise.h"

namespace stof::hal::emu {
namespace {

constexpr double kNearest = 0.85;          // of any object to a camera, metres
constexpr double kDegree = 0.00872664626;  // half tangent of a degree, as long as it is small

// Draws stand in statements and braces of their own: arguments of a call come in any order.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) noexcept : random_(seed) {}
  double between(double low, double high) noexcept {
    return low + (high - low) * (static_cast<double>(random_.next() >> 11U) / 9007199254740992.0);
  }
  int below(int count) noexcept { return static_cast<int>(between(0, static_cast<double>(count))); }
  bool chance(double share) noexcept { return between(0, 1) < share; }
  std::uint32_t word() noexcept { return static_cast<std::uint32_t>(random_.next() >> 32U); }

 private:
  Xorshift64 random_;
};

Material random_material(Draw& draw, double plain_share) {
  Material out{.albedo = draw.between(0.35, 0.85), .seed = draw.word()};
  if (!draw.chance(plain_share)) {
    out.contrast = draw.between(0.3, 0.9);
    // Noise matches well; stripes and checks, which repeat, do not.
    const double kind = draw.between(0, 1);
    out.texture = Texture::kNoise;
    out.period_m = draw.between(0.04, 0.3);
    if (kind > 0.7) {
      out.texture = kind > 0.85 ? Texture::kStripes : Texture::kChecks;
      out.period_m = draw.between(0.06, 0.4);
    }
  }
  if (draw.chance(0.7)) {
    out.nir = draw.between(0.3, 0.85);
  }
  if (draw.chance(0.15)) {
    out.gloss = draw.between(0.02, 0.08);
  }
  return out;
}

// The walls around the left camera, which is at the origin of the room's x and z. Every corner is
// nearer than 7 m.
struct Shell {
  double left;
  double right;
  double floor;    // y below the camera
  double ceiling;  // y above it, negative
  double end;
};

Shell random_shell(Draw& draw) {
  const double height = draw.between(0.8, 1.5);
  return {.left = -draw.between(1.1, 2.6),
          .right = draw.between(1.1, 2.6),
          .floor = height,
          .ceiling = height - draw.between(2.3, 3.0),
          .end = draw.between(3.0, 5.8)};
}

void build_shell(Scene& scene, const Shell& shell, Draw& draw) {
  constexpr double kBehind = -1;
  const double half_length = (shell.end - kBehind) / 2;
  const double middle_z = (shell.end + kBehind) / 2;
  const double half_width = (shell.right - shell.left) / 2;
  const double middle_x = (shell.right + shell.left) / 2;
  const double half_height = (shell.floor - shell.ceiling) / 2;
  const double middle_y = (shell.floor + shell.ceiling) / 2;
  const auto add = [&](const Vec3& at, const Vec3& half, Pose turn) {
    turn.position = at;
    scene.objects.push_back({.shape = Shape::kRectangle,
                             .pose = turn,
                             .half = half,
                             .material = random_material(draw, 0.35)});
  };
  const Pose level = turned(0, kQuarterTurn);
  const Pose sideways = turned(kQuarterTurn);
  add({middle_x, shell.floor, middle_z}, {half_width, half_length, 0}, level);
  add({middle_x, shell.ceiling, middle_z}, {half_width, half_length, 0}, level);
  add({shell.left, middle_y, middle_z}, {half_length, half_height, 0}, sideways);
  add({shell.right, middle_y, middle_z}, {half_length, half_height, 0}, sideways);
  add({middle_x, middle_y, shell.end}, {half_width, half_height, 0}, {});
}

// An object within the shell, or none where the cameras would be too near.
std::optional<SceneObject> random_object(const Shell& shell, Draw& draw) {
  constexpr std::array<Shape, 4> kShapes{Shape::kBox, Shape::kCylinder, Shape::kEllipsoid,
                                         Shape::kRectangle};
  SceneObject object{
      .shape = kShapes[static_cast<std::size_t>(draw.below(4))],
      .pose = turned(draw.between(-0.6, 0.6)),
      .half = {draw.between(0.08, 0.45), draw.between(0.08, 0.6), draw.between(0.08, 0.4)},
      .material = random_material(draw, 0.25)};
  if (draw.chance(0.3)) {  // it leans
    const double pitch = draw.between(-0.3, 0.3);
    object.pose = object.pose * turned(0, pitch, draw.between(-0.3, 0.3));
  }
  const double reach = length(object.half);
  // Above the middle of the floor that is in the picture, more or less.
  const double z = draw.between(kNearest + reach, std::max(shell.end - 0.2, kNearest + reach));
  const double x = draw.between(-0.5, 0.5) * z;
  const bool stands = draw.chance(0.6);
  const double y =
      stands ? shell.floor - object.half.y
             : draw.between(std::max(shell.ceiling, -0.4 * z), std::min(shell.floor, 0.4 * z));
  object.pose.position = {std::clamp(x, shell.left, shell.right), y, z};
  // All cameras are within 0.2 m of the left one.
  constexpr double kRigReach = 0.2;
  if (length(object.pose.position) < kNearest + kRigReach + reach) {
    return std::nullopt;
  }
  return object;
}

void build_lights(Scene& scene, const Shell& shell, Draw& draw) {
  scene.ambient = draw.between(0.35, 0.6);
  const int lamps = 2 + draw.below(3);
  for (int i = 0; i < lamps; ++i) {
    const Vec3 at{draw.between(shell.left + 0.3, shell.right - 0.3), shell.ceiling + 0.25,
                  draw.between(0.3, shell.end - 0.4)};
    scene.lights.push_back({.position = at, .power = draw.between(1.2, 2.4) / lamps});
  }
}

Rig random_rig(Draw& draw) {
  Rig rig = corridor_rig();
  const double focal = draw.between(545, 655);
  rig.stereo.left.fx = focal;
  rig.stereo.left.fy = focal;
  rig.stereo.baseline_m = draw.between(0.08, 0.16);
  constexpr int kStep = 16;  // search ranges are multiples of it
  const double largest = focal * rig.stereo.baseline_m / (kNearest - 0.05);
  rig.disparities = static_cast<int>(std::ceil((largest + 2) / kStep)) * kStep;
  const double focal_pmd = draw.between(150, 175);
  rig.pmd_lens.fx = focal_pmd;
  rig.pmd_lens.fy = focal_pmd;
  rig.pmd_lens.cx = draw.between(85.5, 89.5);
  rig.pmd_lens.cy = draw.between(69.5, 73.5);
  rig.pmd_lens.k1 = draw.between(-0.1, 0);
  const double pitch = draw.between(-2, 2) * kDegree;
  const double yaw = draw.between(-2, 2) * kDegree;
  const double roll = draw.between(-2, 2) * kDegree;
  rig.pmd_to_stereo.rotation = turned(yaw, pitch, roll).rotation;
  const double above = draw.between(0.03, 0.08) * (draw.chance(0.5) ? 1 : -1);
  rig.pmd_to_stereo.translation_m = {rig.stereo.baseline_m / 2 + draw.between(-0.03, 0.03), above,
                                     draw.between(-0.02, 0.02)};
  const Vec3 looks{draw.between(-6, 3), draw.between(-8, 8), draw.between(-2, 2)};
  rig.left_camera_pose = turned(looks.y * kDegree, looks.x * kDegree, looks.z * kDegree);
  rig.pmd.signal_e = 600'000;
  rig.pmd.ambient_e = 7'500;
  rig.pmd.read_noise_e = 80;
  rig.pmd.electrons_per_lsb = 80;
  rig.pmd.bits = 14;
  rig.seed = draw.word();
  return rig;
}

}  // namespace

Room random_room(std::uint32_t seed) {
  Draw draw(dsp::mix(seed) + 0x5EED);
  Room room{.scene = {}, .rig = random_rig(draw)};
  const Shell shell = random_shell(draw);
  build_shell(room.scene, shell, draw);
  const int objects = 5 + draw.below(6);
  for (int placed = 0; placed < objects;) {
    if (const std::optional<SceneObject> object = random_object(shell, draw)) {
      room.scene.objects.push_back(*object);
      ++placed;
    }
  }
  build_lights(room.scene, shell, draw);
  return room;
}

}  // namespace stof::hal::emu
