#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "hal/emu/scenes/vec3.h"

// A world made of a few solid objects. Metres; x right, y down, z forward, floor at y = 0.
// Everything is computed with +, -, *, / and sqrt alone, so that every machine gets the same bits.
namespace stof::hal::emu {

enum class Texture : std::uint8_t {
  kPlain,
  kNoise,    // value noise in five octaves, the coarsest with cells of `period_m`
  kStripes,  // along the object's x axis, so vertical stripes: repetitive for stereo
  kChecks,   // along its x and y axis
  kSpeckle,  // value noise in ten octaves of equal weight: fine grain, faint clouds
  kPrint,    // what Material::print says, in the middle of the object's x and y axis
};

// A printed sheet: square cells of one brightness each, row by row from the top left corner.
struct Print {
  int columns = 0;
  int rows = 0;
  double cell_m = 0;
  std::vector<std::uint8_t> cells;  // 255 white, 0 as dark as the material's contrast says

  // 0..1 at a point of the object's frame; beyond the sheet its border goes on.
  double brightness(const Vec3& local) const noexcept;
  // Every point between the two has one brightness. May say no where they have.
  bool is_uniform(const Vec3& low, const Vec3& high) const noexcept;
};

struct Material {
  double albedo = 0.8;  // diffuse, 0..1, of the bright parts of a texture
  double contrast = 0;  // the darkest parts have albedo (1 - contrast); 0..1
  Texture texture = Texture::kPlain;
  double period_m = 0.1;
  std::uint32_t seed = 0;       // of kNoise and kSpeckle
  std::optional<double> nir{};  // albedo in the PMD camera's infrared, untextured; none: as visible
  // A glossy coat: mirrors this share of the lights, each widened to cos^(2^gloss_log2).
  // Its image depends on the viewpoint: the two cameras see it at different places.
  double gloss = 0;  // 0..1
  int gloss_log2 = 6;
  // A pane: the share of light that it lets through each way. Objects behind it are seen through
  // it, other panes are not.
  double transmittance = 0;      // 0..1
  const Print* print = nullptr;  // of kPrint; Scene::prints keeps it
};

enum class Shape : std::uint8_t {
  kRectangle,  // half.x by half.y in the object's plane z = 0, visible from both sides
  kBox,        // half sizes
  kCylinder,   // axis along y: radii half.x and half.z, half height half.y, closed
  kEllipsoid,  // radii
};

struct SceneObject {
  Shape shape = Shape::kBox;
  Pose pose{};  // of the object in the world; its origin is the shape's centre
  Vec3 half{0.5, 0.5, 0.5};
  Material material{};
};

struct Light {
  Vec3 position;
  double power = 1;  // irradiance at 1 m, head-on
};

struct Scene {
  std::vector<SceneObject> objects;
  std::vector<Light> lights;
  double ambient = 0.4;                                // irradiance from everywhere
  std::vector<std::shared_ptr<const Print>> prints{};  // what materials point to
};

// One object more, its centre at `at`, turned as `turn`.
void add(Scene& scene, Shape shape, const Vec3& at, const Vec3& half, const Material& material,
         Pose turn = {});

// The book chapter's Figure 21: white walls, floor and ceiling, an end wall at 6.6 m, a column, a
// person in a checked shirt, a low carton; skirting boards, doors, a picture, a speckled and
// slightly glossy floor. Depths from 2 to 6.7 m for corridor_rig(). Made for a left camera at (0,
// -1, 0).
Scene corridor();
Scene empty_corridor();  // without the person

// A hall of 7 by 4.8 m that ends at 13.6 m, beyond the range of a PMD camera at 20 MHz: textured
// walls, floor and boxes from 2.4 to 13.6 m; a ceiling, a column, panels and banners of one colour,
// on which stereo sees nothing. Made for hall_rig().
Scene hall();

// One white wall of the given albedo, facing the viewpoint at z = distance_m, 40 m wide and high.
Scene wall(double distance_m, const Material& material = {});

// Where a ray meets the scene.
struct Hit {
  double t = 0;     // origin + t * direction
  int object = -1;  // index in Scene::objects; -1: nothing
  int face = 0;     // of that object: points with the same one lie on one smooth surface
  Vec3 point;       // world
  Vec3 normal;      // world, unit, towards the viewpoint
  Vec3 local;       // the point in the object's frame
};

// Reflectance 0..1 at a point of the object's frame.
double visible_albedo(const Material& material, const Vec3& local) noexcept;
double infrared_albedo(const Material& material, const Vec3& local) noexcept;

// The light that reaches a hit and leaves it towards the viewpoint; no shadows.
struct Lighting {
  double diffuse = 0;   // irradiance, Lambert's law and ambient: times the albedo
  double mirrored = 0;  // by the coat
};
Lighting lighting(const Scene& scene, const Hit& hit, const Vec3& viewpoint) noexcept;

// Light that leaves the hit towards the viewpoint: albedo * diffuse + mirrored.
double radiance(const Scene& scene, const Hit& hit, const Vec3& viewpoint) noexcept;

}  // namespace stof::hal::emu
