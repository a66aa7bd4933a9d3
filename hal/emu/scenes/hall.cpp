#include "hal/emu/scenes/scene.h"

namespace stof::hal::emu {
namespace {

// World: floor y = 0, ceiling y = -4.8, walls x = +-3.5, end wall z = 13.6.
constexpr double kHalfWidth = 3.5;
constexpr double kHeight = 4.8;
constexpr double kEnd = 13.6;
constexpr double kBegin = -1.0;
constexpr double kMiddle = (kBegin + kEnd) / 2;
constexpr double kHalfLength = (kEnd - kBegin) / 2;

// Coarse enough that its finest octaves are a pixel or more where it is seen.
constexpr Material noise(double albedo, double contrast, double period_m, std::uint32_t seed) {
  return {.albedo = albedo,
          .contrast = contrast,
          .texture = Texture::kNoise,
          .period_m = period_m,
          .seed = seed};
}

constexpr Material kPlain{.albedo = 0.75};
constexpr Material kGrey{.albedo = 0.5};

void build_shell(Scene& scene) {
  const Pose sideways = turned(kQuarterTurn);
  const Pose level = turned(0, kQuarterTurn);
  const double middle_y = -kHeight / 2;
  add(scene, Shape::kRectangle, {0, 0, kMiddle}, {kHalfWidth, kHalfLength, 0},
      noise(0.6, 0.6, 0.35, 1), level);
  add(scene, Shape::kRectangle, {0, -kHeight, kMiddle}, {kHalfWidth, kHalfLength, 0}, kPlain,
      level);
  std::uint32_t seed = 2;
  for (const double side : {-kHalfWidth, kHalfWidth}) {
    add(scene, Shape::kRectangle, {side, middle_y, kMiddle}, {kHalfLength, kHeight / 2, 0},
        noise(0.75, 0.55, 0.6, seed++), sideways);
  }
  add(scene, Shape::kRectangle, {0, middle_y, kEnd}, {kHalfWidth, kHeight / 2, 0},
      noise(0.75, 0.6, 0.8, seed));
}

// What is of one colour.
void build_plain_objects(Scene& scene) {
  add(scene, Shape::kBox, {1.5, -2.6, kEnd}, {1.1, 0.8, 0.03}, kPlain);         // end wall
  add(scene, Shape::kBox, {kHalfWidth, -2.2, 8.6}, {0.03, 1.1, 1.3}, kPlain);   // right wall
  add(scene, Shape::kBox, {-kHalfWidth, -2.6, 11.4}, {0.03, 0.9, 1.0}, kGrey);  // left wall
  add(scene, Shape::kCylinder, {-2.7, -2.4, 7.2}, {0.22, 2.4, 0.22}, kPlain);   // column
  add(scene, Shape::kBox, {0.55, -0.45, 5.1}, {0.35, 0.45, 0.3}, kGrey, turned(0.12));
  add(scene, Shape::kRectangle, {0.6, -3.7, 9.6}, {1.2, 0.45, 0}, kPlain);  // banner
}

struct Crate {
  Vec3 at;
  Vec3 half;
  double turn;
};

void build_crates(Scene& scene) {
  constexpr std::array<Crate, 10> kCrates{{
      {{-0.75, -0.5, 2.7}, {0.3, 0.5, 0.3}, 0.1},
      {{1.1, -0.6, 3.6}, {0.4, 0.6, 0.35}, -0.15},
      {{-1.7, -0.75, 5.0}, {0.5, 0.75, 0.4}, 0.2},
      {{2.3, -0.9, 6.3}, {0.55, 0.9, 0.5}, 0},
      {{-0.4, -0.6, 7.3}, {0.5, 0.6, 0.45}, -0.1},
      {{1.4, -0.75, 8.4}, {0.55, 0.75, 0.5}, 0.15},
      {{-1.6, -0.9, 9.4}, {0.6, 0.9, 0.5}, 0.05},
      {{2.6, -1.0, 10.6}, {0.6, 1.0, 0.5}, -0.2},
      {{0.3, -0.8, 11.4}, {0.7, 0.8, 0.5}, 0.1},
      {{-2.6, -1.1, 12.4}, {0.6, 1.1, 0.5}, 0},
  }};
  std::uint32_t seed = 20;
  for (const Crate& crate : kCrates) {
    const double period = crate.at.z < 6 ? 0.2 : 0.4;
    const double albedo = seed % 2 == 0 ? 0.7 : 0.5;
    add(scene, Shape::kBox, crate.at, crate.half, noise(albedo, 0.6, period, seed++),
        turned(crate.turn));
  }
  add(scene, Shape::kCylinder, {2.25, -2.4, 4.9}, {0.2, 2.4, 0.2}, noise(0.7, 0.5, 0.2, 40));
  add(scene, Shape::kRectangle, {-1.5, -3.5, 8.1}, {0.9, 0.5, 0}, noise(0.75, 0.7, 0.4, 41));
}

}  // namespace

Scene hall() {
  Scene scene;
  scene.ambient = 0.6;
  build_shell(scene);
  build_plain_objects(scene);
  build_crates(scene);
  // Let into the ceiling, which they do not light.
  for (const double z : {0.5, 4.0, 7.5, 11.0}) {
    scene.lights.push_back({.position = {0, -kHeight - 0.02, z}, .power = 3.2});
  }
  return scene;
}

}  // namespace stof::hal::emu
