#include "hal/emu/scenes/scene.h"

#include <algorithm>
#include <cmath>

#include "dsp/base/random.h"

namespace stof::hal::emu {
namespace {

// Each octave of noise has cells of half the size of those before it, and this share of their
// weight.
struct Octaves {
  std::uint32_t count;
  double weight;
  double stretch;  // the sum crowds around the middle; stretched, it uses the whole range
};
constexpr Octaves kCloudy{.count = 5, .weight = 0.75, .stretch = 1.8};
constexpr Octaves kGrainy{.count = 10, .weight = 1, .stretch = 3};

double lattice(std::int64_t x, std::int64_t y, std::int64_t z, std::uint32_t seed) noexcept {
  const std::uint64_t word = static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15ULL +
                             static_cast<std::uint64_t>(y) * 0xC2B2AE3D27D4EB4FULL +
                             static_cast<std::uint64_t>(z) * 0x165667B19E3779F9ULL + seed;
  return static_cast<double>(dsp::mix(word) >> 32U) / 4294967296.0;
}

constexpr double blend(double a, double b, double t) noexcept { return a + t * (b - a); }
constexpr double ease(double t) noexcept { return t * t * (3 - 2 * t); }

// Uniform random values on the integer lattice, blended smoothly; 0..1.
double value_noise(const Vec3& p, std::uint32_t seed) noexcept {
  const double fx = std::floor(p.x);
  const double fy = std::floor(p.y);
  const double fz = std::floor(p.z);
  const std::int64_t x = static_cast<std::int64_t>(fx);
  const std::int64_t y = static_cast<std::int64_t>(fy);
  const std::int64_t z = static_cast<std::int64_t>(fz);
  const double tx = ease(p.x - fx);
  const double ty = ease(p.y - fy);
  const double tz = ease(p.z - fz);
  const auto row = [&](std::int64_t j, std::int64_t k) {
    return blend(lattice(x, j, k, seed), lattice(x + 1, j, k, seed), tx);
  };
  return blend(blend(row(y, z), row(y + 1, z), ty), blend(row(y, z + 1), row(y + 1, z + 1), ty),
               tz);
}

double noise(const Vec3& p, const Octaves& octaves, double period, std::uint32_t seed) noexcept {
  double sum = 0;
  double weights = 0;
  double weight = 1;
  double scale = 1 / period;
  for (std::uint32_t octave = 0; octave < octaves.count; ++octave) {
    sum += weight * value_noise(scale * p, seed + octave);
    weights += weight;
    weight *= octaves.weight;
    scale *= 2;
  }
  return std::clamp(0.5 + octaves.stretch * (sum / weights - 0.5), 0.0, 1.0);
}

// Shifted, so that no cell ends where a box's side usually lies.
bool odd(double cells) noexcept {
  const double whole = std::floor(cells + 0.37);
  return whole - 2 * std::floor(whole / 2) > 0.5;
}

double brightness(const Material& material, const Vec3& local) noexcept {
  switch (material.texture) {
    case Texture::kNoise:
      return noise(local, kCloudy, material.period_m, material.seed);
    case Texture::kSpeckle:
      return noise(local, kGrainy, material.period_m, material.seed);
    case Texture::kStripes:
      return odd(2 * local.x / material.period_m) ? 0 : 1;
    case Texture::kChecks:
      return odd(2 * local.x / material.period_m) != odd(2 * local.y / material.period_m) ? 0 : 1;
    case Texture::kPrint:
      return material.print->brightness(local);
    case Texture::kPlain:
      break;
  }
  return 1;
}

// The column or row of a place that is counted from the sheet's middle.
int cell_at(double place_m, double cell_m, int cells) noexcept {
  const double cell = std::floor(place_m / cell_m + cells / 2.0);
  return static_cast<int>(std::clamp(cell, 0.0, cells - 1.0));
}

}  // namespace

double Print::brightness(const Vec3& local) const noexcept {
  const int row = cell_at(local.y, cell_m, rows);
  const int column = cell_at(local.x, cell_m, columns);
  return cells[static_cast<std::size_t>(row * columns + column)] / 255.0;
}

bool Print::is_uniform(const Vec3& low, const Vec3& high) const noexcept {
  constexpr int kMost = 3;  // cells a side that are looked at
  const int left = cell_at(low.x, cell_m, columns);
  const int right = cell_at(high.x, cell_m, columns);
  const int top = cell_at(low.y, cell_m, rows);
  const int bottom = cell_at(high.y, cell_m, rows);
  if (right - left >= kMost || bottom - top >= kMost) {
    return false;
  }
  const std::uint8_t first = cells[static_cast<std::size_t>(top * columns + left)];
  for (int row = top; row <= bottom; ++row) {
    for (int column = left; column <= right; ++column) {
      if (cells[static_cast<std::size_t>(row * columns + column)] != first) {
        return false;
      }
    }
  }
  return true;
}

void add(Scene& scene, Shape shape, const Vec3& at, const Vec3& half, const Material& material,
         Pose turn) {
  turn.position = at;
  scene.objects.push_back({.shape = shape, .pose = turn, .half = half, .material = material});
}

double visible_albedo(const Material& material, const Vec3& local) noexcept {
  if (material.texture == Texture::kPlain || material.contrast == 0) {
    return material.albedo;
  }
  return material.albedo * (1 - material.contrast * (1 - brightness(material, local)));
}

double infrared_albedo(const Material& material, const Vec3& local) noexcept {
  return material.nir ? *material.nir : visible_albedo(material, local);
}

Lighting lighting(const Scene& scene, const Hit& hit, const Vec3& viewpoint) noexcept {
  const Material& material = scene.objects[static_cast<std::size_t>(hit.object)].material;
  const Vec3 to_eye = unit(viewpoint - hit.point);
  Lighting out{.diffuse = scene.ambient, .mirrored = 0};
  for (const Light& light : scene.lights) {
    const Vec3 path = light.position - hit.point;
    const double square = dot(path, path);
    const Vec3 to_light = (1 / std::sqrt(square)) * path;
    const double cosine = dot(hit.normal, to_light);
    if (cosine <= 0) {
      continue;
    }
    out.diffuse += light.power * cosine / square;
    if (material.gloss > 0) {
      const Vec3 mirrored = 2 * cosine * hit.normal - to_light;
      double lobe = std::max(0.0, dot(mirrored, to_eye));
      double exponent = 1;
      for (int i = 0; i < material.gloss_log2; ++i) {
        lobe *= lobe;
        exponent *= 2;
      }
      lobe *= (exponent + 2) / 2;  // a narrower lobe is brighter
      out.mirrored += material.gloss * light.power / square * lobe;
    }
  }
  return out;
}

double radiance(const Scene& scene, const Hit& hit, const Vec3& viewpoint) noexcept {
  const Material& material = scene.objects[static_cast<std::size_t>(hit.object)].material;
  const Lighting light = lighting(scene, hit, viewpoint);
  return visible_albedo(material, hit.local) * light.diffuse + light.mirrored;
}

Scene wall(double distance_m, const Material& material) {
  Scene scene;
  scene.ambient = 0.7;
  add(scene, Shape::kRectangle, {0, 0, distance_m}, {20, 20, 0}, material);
  return scene;
}

}  // namespace stof::hal::emu
