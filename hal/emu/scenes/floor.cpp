#include "hal/emu/scenes/floor.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "hal/emu/scenes/materials.h"

namespace stof::hal::emu {
namespace {

using dataset::Surface;

constexpr double kFarthestWall = 5;
constexpr double kFarthestThing = 4;
constexpr double kStepDown = 0.1;
constexpr double kHalfWidth = 6;     // of the floor and the wall, more than is seen
constexpr double kBehind = -1;       // where the floor begins
constexpr double kFullHeight = 0.6;  // of the camera: what is mounted lower has a smaller rig

// A few grey levels of grain, and clouds as faint: linoleum, smooth concrete, short carpet.
Material floor_material(std::uint32_t seed) {
  return {.albedo = 0.5,
          .contrast = 0.16,
          .texture = Texture::kSpeckle,
          .period_m = 0.4,
          .seed = seed,
          .nir = 0.5};
}

// Clean, so that little light comes from itself.
constexpr Material kGlass{.albedo = 0.03, .nir = 0.06, .transmittance = 0.9};

// Distances along the floor.
struct Layout {
  double box;
  double pane;
  double edge;
  double wall;
};

// Where the ray (0, y, 1) of the camera meets the floor; infinite where it does not.
double floor_distance(const Pose& camera, double y) {
  const Vec3 ray = camera.turn({0, y, 1});
  return ray.y > 0 ? -camera.position.y * ray.z / ray.y : std::numeric_limits<double>::infinity();
}

Layout lay_out(const Rig& rig) {
  const dsp::Pinhole& lens = rig.stereo.left;
  const double nearest =
      floor_distance(rig.left_camera_pose, (lens.height - 0.5 - lens.cy) / lens.fy);
  const double farthest = floor_distance(rig.left_camera_pose, (-0.5 - lens.cy) / lens.fy);
  const double wall = std::min(kFarthestWall, 0.85 * farthest);
  // 0: the bottom row of the picture; 1: 4 m or the wall. Shares between are nearly those of rows.
  const auto at = [&](double share) {
    return 1 / ((1 - share) / nearest + share / std::min(kFarthestThing, wall));
  };
  return {.box = at(0.45), .pane = at(0.6), .edge = at(0.75), .wall = wall};
}

Rig floor_rig(const FloorView& view) {
  constexpr int kStep = 16;  // search ranges are multiples of it
  const double low = std::min(1.0, view.height_m / kFullHeight);
  Rig rig = corridor_rig();
  rig.stereo.baseline_m *= low;
  rig.pmd_to_stereo.translation_m[0] = rig.stereo.baseline_m / 2;
  rig.left_camera_pose = turned(0, -half_tangent(view.tilt_degrees));
  rig.left_camera_pose.position = {0, -view.height_m, 0};
  // Z of the floor in the bottom row.
  const dsp::Pinhole& lens = rig.stereo.left;
  const Vec3 lowest = rig.left_camera_pose.turn({0, (lens.height - 0.5 - lens.cy) / lens.fy, 1});
  const double largest = lens.fx * rig.stereo.baseline_m * lowest.y / view.height_m;
  rig.disparities = static_cast<int>(std::ceil((largest + 2) / kStep)) * kStep;
  rig.pmd.signal_e = 600'000 * low * low;
  rig.pmd.ambient_e = 7'500;
  rig.pmd.read_noise_e = 80;
  rig.pmd.electrons_per_lsb = 80;
  rig.pmd.bits = 14;
  return rig;
}

class FloorBuilder {
 public:
  explicit FloorBuilder(const FloorView& view)
      : out_{.scene = {}, .surfaces = {}, .rig = floor_rig(view)},
        layout_(lay_out(out_.rig)),
        material_(floor_material(view.seed)) {}

  FloorScene take() && {
    build_floor();
    build_objects();
    build_lamps();
    return std::move(out_);
  }

 private:
  struct Range {
    double from;
    double to;
    double half() const { return (to - from) / 2; }
    double middle() const { return (from + to) / 2; }
  };

  void put(Surface surface, Shape shape, const Vec3& at, const Vec3& half, const Material& material,
           const Pose& turn = {}) {
    add(out_.scene, shape, at, half, material, turn);
    out_.surfaces.push_back(surface);
  }

  void put_level(Surface surface, const Range& x, double y, const Range& z) {
    put(surface, Shape::kRectangle, {x.middle(), y, z.middle()}, {x.half(), z.half(), 0}, material_,
        turned(0, kQuarterTurn));
  }

  void build_floor() {
    const double left = 0.2 * layout_.edge;  // end of the lower floor; its side is not seen
    put_level(Surface::kFloor, {-kHalfWidth, left}, 0, {kBehind, layout_.wall});
    put_level(Surface::kFloor, {left, kHalfWidth}, 0, {kBehind, layout_.edge});
    put_level(Surface::kLowerFloor, {left, kHalfWidth}, kStepDown, {layout_.edge, layout_.wall});
  }

  // What is nearer is smaller, so that the floor is seen around it.
  void build_objects() {
    const double side = std::min(0.15, 0.1 * layout_.box);
    put(Surface::kBox, Shape::kBox, {0.04 * layout_.box, -side, layout_.box + side},
        {side, side, side}, material::kCarton);
    const double half = std::min(0.3, 0.12 * layout_.pane);
    put(Surface::kGlass, Shape::kRectangle, {-0.24 * layout_.pane, -half, layout_.pane},
        {half, half, 0}, kGlass);
    put(Surface::kWall, Shape::kRectangle, {0, 0, layout_.wall}, {kHalfWidth, kHalfWidth, 0},
        material::kWhite);
  }

  void build_lamps() {
    constexpr double kCeiling = 2.5;
    out_.scene.ambient = 0.5;
    for (const double z : {0.0, 0.5 * layout_.wall}) {
      out_.scene.lights.push_back({.position = {0, -kCeiling, z}, .power = 1.5});
    }
  }

  FloorScene out_;
  Layout layout_;
  Material material_;
};

}  // namespace

FloorScene floor_scene(const FloorView& view) { return FloorBuilder(view).take(); }

}  // namespace stof::hal::emu
