#include "dsp/calib/pmd/emitter_offset_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "dsp/calib/pmd/ray_table.h"

namespace stof::dsp {
namespace {

// Light falls with this power of the cosine to the lens's axis: cos^3 of the lobe (half at 37
// degrees, common for the lights of PMD cameras), once more at a surface that faces the camera.
constexpr double kCosinePower = 4;
constexpr std::array<double, 2> kFittedM{0.5, 1.5};
constexpr double kShortestM = 0.3;
constexpr double kFlatM = 1e-6;  // a correction without this much of a bend is a straight line

using Ray = std::array<double, 3>;

double dot(const Ray& a, const Ray& b) noexcept { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// d = L / 2 + half - area / (2 (L - pole)), metres.
struct Model {
  double half = 0;
  double area = 0;
  double pole = 0;
};

std::span<const Emitter> lights(const PmdSensor& sensor) noexcept {
  return std::span(sensor.emitters).first(index(sensor.emitter_count));
}

// The way of the light to the surface at distance d along the ray and back.
double mean_way(const PmdSensor& sensor, const Ray& ray, double d) noexcept {
  double weights = 0;
  double sum = 0;
  for (const Emitter& e : lights(sensor)) {
    const Ray out{d * ray[0] - e[0], d * ray[1] - e[1], d * ray[2] - e[2]};
    const double length = std::sqrt(dot(out, out));
    const double weight =
        std::pow(std::max(out[2], 0.0) / length, kCosinePower) / (length * length);
    weights += weight;
    sum += weight * length;
  }
  return weights > 0 ? d + sum / weights : 2 * d;  // lights that do not reach the surface
}

Model model_of(const PmdSensor& sensor, const Ray& ray) noexcept {
  const double n = sensor.emitter_count;
  double c = 0;
  double area = 0;
  for (const Emitter& e : lights(sensor)) {
    const double along = dot(e, ray);
    c += along / n;
    area += (dot(e, e) - along * along) / n;
  }
  if (sensor.emitter_count == 1) {
    return {c / 2, area, c};
  }
  std::array<double, 2> way{};
  std::array<double, 2> bend{};
  for (std::size_t k = 0; k < 2; ++k) {
    way[k] = mean_way(sensor, ray, kFittedM[k]);
    bend[k] = way[k] / 2 + c / 2 - kFittedM[k];
  }
  // area = 2 bend (way - pole) at both. Where the bend does not fall with the way, the pole says
  // nothing and only the nearer distance counts.
  double pole = c;
  if (bend[0] * bend[1] > 0 && std::abs(bend[0]) > std::abs(bend[1])) {
    pole = (bend[0] * way[0] - bend[1] * way[1]) / (bend[0] - bend[1]);
    pole = std::clamp(pole, -4 * way[0], way[0] / 2);
  }
  if (std::abs(bend[0]) < kFlatM) {
    return {c / 2, 0, c};
  }
  return {c / 2, 2 * bend[0] * (way[0] - pole), pole};
}

template <typename T>
T rounded(double value, double limit) noexcept {
  return static_cast<T>(std::clamp(std::round(value), -limit, limit));
}

}  // namespace

void fill_emitter_offset_table(const PmdSensor& sensor, double units_per_metre,
                               const EmitterOffsetTable& table) noexcept {
  const std::size_t count = pixel_count(sensor.lens.width, sensor.lens.height);
  STOF_CHECK(sensor.emitter_count > 0 && sensor.emitter_count <= kMaxEmitters);
  STOF_CHECK(table.half_q2.size() == count && table.twice_area.size() == count &&
             table.pole.size() == count);
  std::size_t i = 0;
  for (int v = 0; v < sensor.lens.height; ++v) {
    for (int u = 0; u < sensor.lens.width; ++u, ++i) {
      const Ray ray = unit_ray(sensor.lens, u, v);
      const Model model = ray[2] > 0 ? model_of(sensor, ray) : Model{};
      const double square = units_per_metre * units_per_metre;
      table.half_q2[i] = rounded<std::int16_t>(4 * model.half * units_per_metre, 32767);
      table.twice_area[i] = rounded<std::int32_t>(2 * model.area * square, 2147483647);
      table.pole[i] = rounded<std::int32_t>(model.pole * units_per_metre, (1 << 20) - 1);
    }
  }
}

EmitterOffsetTable make_emitter_offset_table(const PmdSensor& sensor, double units_per_metre,
                                             Arena& arena) noexcept {
  const std::size_t count = pixel_count(sensor.lens.width, sensor.lens.height);
  const EmitterOffsetTable table{arena.take<std::int16_t>(count), arena.take<std::int32_t>(count),
                                 arena.take<std::int32_t>(count)};
  if (!arena.is_measuring()) {
    fill_emitter_offset_table(sensor, units_per_metre, table);
  }
  return table;
}

std::uint32_t shortest_way(const PmdSensor& sensor, double units_per_metre) noexcept {
  return sensor.emitter_count > 1
             ? static_cast<std::uint32_t>(std::lround(2 * kShortestM * units_per_metre))
             : 0;
}

}  // namespace stof::dsp
