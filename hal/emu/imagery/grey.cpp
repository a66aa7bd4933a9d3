#include "hal/emu/imagery/grey.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "dsp/base/fixed.h"
#include "hal/emu/imagery/noise.h"

namespace stof::hal::emu {
namespace {

constexpr int kEdgeRays = 6;     // a side
constexpr int kTextureRays = 3;  // a side
constexpr int kPrintRays = 233;  // of a pixel: a Fibonacci number
constexpr int kPrintStep = 144;  // the one before it
constexpr double kMaxLevel = 2 * 255.0;

// A smooth surface of one object, or nothing.
struct Patch {
  int object = -1;
  int face = 0;
  friend bool operator==(const Patch&, const Patch&) = default;
};

class GreyRenderer {
 public:
  GreyRenderer(const Scene& scene, const Viewpoint& viewpoint, const LensRays& rays)
      : scene_(scene), viewpoint_(viewpoint), rays_(rays) {}

  // The patches at the corners along the top of row y from pixel run.begin to run.end, one more
  // than pixels.
  std::vector<Patch> corners(int y, const Run& run) const {
    std::vector<Patch> out;
    for (int x = run.begin; x <= run.end; ++x) {
      const Hit hit = look(x - 0.5, y - 0.5);
      out.push_back({hit.object, hit.face});
    }
    return out;
  }

  // Whether object `first` or a later one may be seen within the pixel.
  bool may_show(int x, int y, int first) const {
    return viewpoint_.may_show(first, rays_.window(x, y));
  }

  // Mean radiance over the pixel whose four corners lie on `around`; nothing where all of it shows
  // one surface of an object before `first`.
  std::optional<double> pixel(int x, int y, const std::array<Patch, 4>& around, int first) const {
    const Hit centre = look(x, y);
    const Patch patch{centre.object, centre.face};
    const Vec3& from = viewpoint_.pose().position;
    if (!std::ranges::all_of(around, [&](const Patch& corner) { return corner == patch; })) {
      return mean_light(x, y);
    }
    if (centre.object >= 0 && material_of(centre).transmittance > 0) {
      return mean_light(x, y);
    }
    if (centre.object < first) {
      return std::nullopt;
    }
    const Material& material = material_of(centre);
    if (material.texture == Texture::kPlain) {
      return radiance(scene_, centre, from);
    }
    // Light changes little within a pixel of one surface; its texture may change a lot.
    const Lighting light = lighting(scene_, centre, from);
    if (material.texture == Texture::kPrint) {
      return print_albedo(x, y, centre.object) * light.diffuse + light.mirrored;
    }
    const double albedo = mean(x, y, kTextureRays, [&](double rx, double ry) {
      const Hit hit = viewpoint_.look_at(centre.object, rx, ry);
      return visible_albedo(material, hit.object < 0 ? centre.local : hit.local);
    });
    return albedo * light.diffuse + light.mirrored;
  }

 private:
  Hit look(double u, double v) const {
    const Vec3 ray = rays_.at(u, v);
    return viewpoint_.look(ray.x, ray.y);
  }

  const Material& material_of(const Hit& hit) const {
    return scene_.objects[static_cast<std::size_t>(hit.object)].material;
  }

  // Mean albedo of a print that fills the pixel. Edges between its cells are what a calibration
  // measures: kPrintRays rays of a Fibonacci lattice, which tells the share of a straight edge's
  // sides to 1/kPrintRays where it is upright or level, and to about 0.01 where not.
  double print_albedo(int x, int y, int object) const {
    const SceneObject& sheet = scene_.objects[static_cast<std::size_t>(object)];
    const auto albedo = [&](double u, double v) {
      const Vec3 ray = rays_.at(u, v);
      return visible_albedo(sheet.material, viewpoint_.look_at(object, ray.x, ray.y).local);
    };
    constexpr double kInside = 0.4999;  // of the pixel's corners, which are others' too
    Vec3 low{1e9, 1e9, 0};
    Vec3 high{-1e9, -1e9, 0};
    for (const double dv : {-kInside, kInside}) {
      for (const double du : {-kInside, kInside}) {
        const Vec3 ray = rays_.at(x + du, y + dv);
        const Vec3 corner = viewpoint_.look_at(object, ray.x, ray.y).local;
        low = {std::min(low.x, corner.x), std::min(low.y, corner.y), 0};
        high = {std::max(high.x, corner.x), std::max(high.y, corner.y), 0};
      }
    }
    if (sheet.material.print->is_uniform(low, high)) {
      return albedo(x, y);
    }
    double sum = 0;
    for (int i = 0; i < kPrintRays; ++i) {
      const double du = (i + 0.5) / kPrintRays - 0.5;
      const double dv = ((i * kPrintStep) % kPrintRays + 0.5) / kPrintRays - 0.5;
      sum += albedo(x + du, y + dv);
    }
    return sum / kPrintRays;
  }

  // Radiance of whatever surfaces meet in the pixel, and of what is behind panes.
  double mean_light(int x, int y) const {
    const Vec3& from = viewpoint_.pose().position;
    const auto own = [&](const Hit& hit) {
      return hit.object < 0 ? 0 : radiance(scene_, hit, from);
    };
    return mean(x, y, kEdgeRays, [&](double rx, double ry) {
      const Hit hit = viewpoint_.look(rx, ry);
      const double transmittance = hit.object < 0 ? 0 : material_of(hit).transmittance;
      return transmittance == 0
                 ? own(hit)
                 : own(hit) + transmittance * own(viewpoint_.look_past(hit.object, rx, ry));
    });
  }

  // Of value(ray x, ray y) over side x side rays spread evenly over the pixel.
  template <typename Value>
  double mean(int x, int y, int side, const Value& value) const {
    double sum = 0;
    for (int j = 0; j < side; ++j) {
      for (int i = 0; i < side; ++i) {
        const double u = x - 0.5 + (i + 0.5) / side;
        const double v = y - 0.5 + (j + 0.5) / side;
        const Vec3 ray = rays_.at(u, v);
        sum += value(ray.x, ray.y);
      }
    }
    return sum / (side * side);
  }

  const Scene& scene_;
  const Viewpoint& viewpoint_;
  const LensRays& rays_;
};

std::uint16_t level_of(double radiance, const GreyModel& model) noexcept {
  const double level = std::clamp(model.black + model.gain * radiance, 0.0, kMaxLevel);
  return static_cast<std::uint16_t>(std::floor(level * (1 << kGreyBits) + 0.5));
}

}  // namespace

void render_grey_over(const Scene& scene, const Viewpoint& viewpoint, const LensRays& rays,
                      const GreyModel& model, std::span<const Run> runs, int first,
                      dataset::Image<std::uint16_t>& out) {
  const GreyRenderer renderer(scene, viewpoint, rays);
  Run last;  // what `below` belongs to
  std::vector<Patch> below;
  for (int y = 0; y < rays.lens().height; ++y) {
    const Run& run = runs[static_cast<std::size_t>(y)];
    const bool same = y > 0 && run == last;
    last = run;
    if (run.end <= run.begin) {
      continue;
    }
    const std::vector<Patch> above = same ? std::move(below) : renderer.corners(y, run);
    below = renderer.corners(y + 1, run);
    const std::span<std::uint16_t> row = out.view().row(y);
    for (int x = run.begin; x < run.end; ++x) {
      if (!renderer.may_show(x, y, first)) {
        continue;
      }
      const std::size_t i = static_cast<std::size_t>(x - run.begin);
      const std::optional<double> value =
          renderer.pixel(x, y, {above[i], above[i + 1], below[i], below[i + 1]}, first);
      if (value) {
        row[static_cast<std::size_t>(x)] = level_of(*value, model);
      }
    }
  }
}

dataset::Image<std::uint16_t> render_grey(const Scene& scene, const Viewpoint& viewpoint,
                                          const LensRays& rays, const GreyModel& model) {
  const dsp::Pinhole& lens = rays.lens();
  dataset::Image<std::uint16_t> out(lens.width, lens.height, level_of(0, model));
  render_grey_over(scene, viewpoint, rays, model, whole_picture(lens), 0, out);
  return out;
}

namespace {

// Of each pixel value(what its centre shows, the direction of that).
template <typename Pixel, typename Value>
dataset::Image<Pixel> map_of_centres(const Viewpoint& viewpoint, const LensRays& rays,
                                     const Value& value) {
  const dsp::Pinhole& lens = rays.lens();
  dataset::Image<Pixel> out(lens.width, lens.height);
  for (int y = 0; y < lens.height; ++y) {
    for (int x = 0; x < lens.width; ++x) {
      const Vec3 ray = rays.at(x, y);
      out.view().at(x, y) = value(viewpoint.look(ray.x, ray.y), ray);
    }
  }
  return out;
}

}  // namespace

dataset::Image<float> render_depth(const Viewpoint& viewpoint, const LensRays& rays,
                                   const Vec3& along) {
  return map_of_centres<float>(viewpoint, rays, [&along](const Hit& hit, const Vec3& ray) {
    return hit.object < 0 ? std::numeric_limits<float>::infinity()
                          : static_cast<float>(hit.t * dot(ray, along));
  });
}

dataset::Image<int> render_objects(const Viewpoint& viewpoint, const LensRays& rays) {
  return map_of_centres<int>(viewpoint, rays,
                             [](const Hit& hit, const Vec3&) { return hit.object; });
}

dataset::Image<std::uint8_t> render_visible(const Viewpoint& viewpoint, const LensRays& rays,
                                            const Viewpoint& other,
                                            const dsp::Pinhole& other_lens) {
  constexpr double kSame =
      1.001;  // the other viewpoint's ray ends at most 0.1 percent before the point
  return map_of_centres<std::uint8_t>(
      viewpoint, rays, [&](const Hit& hit, const Vec3&) -> std::uint8_t {
        const Vec3 point = other.pose().undo(hit.point);
        if (hit.object < 0 || point.z <= 0) {
          return 0;
        }
        const double rx = point.x / point.z;
        const double ry = point.y / point.z;
        const PicturePoint at = project(other_lens, rx, ry);
        const bool inside = at.u >= -0.5 && at.u <= other_lens.width - 0.5 && at.v >= -0.5 &&
                            at.v <= other_lens.height - 0.5;
        const Hit first = other.look(rx, ry);
        return inside && first.object >= 0 && first.t * kSame >= point.z ? 255 : 0;
      });
}

std::vector<std::uint16_t> grey_noise(const GreyModel& model) {
  std::vector<std::uint16_t> out;
  for (int level = 0; level < 256; ++level) {
    const double shot = std::max(0.0, level - model.black) / model.electrons_per_level;
    const double sigma = std::sqrt(shot + model.read_noise * model.read_noise);
    out.push_back(static_cast<std::uint16_t>(std::floor(sigma * (1 << kGreyBits) + 0.5)));
  }
  return out;
}

void expose_grey(dsp::ImageView<const std::uint16_t> clean, std::span<const std::uint16_t> sigma,
                 std::uint64_t seed, dsp::ImageView<std::uint8_t> out) noexcept {
  STOF_CHECK(dsp::same_size(clean, out) && sigma.size() == 256);
  GaussianNoise gaussian(seed);
  for (int y = 0; y < out.height(); ++y) {
    const std::span<const std::uint16_t> from = clean.row(y);
    const std::span<std::uint8_t> to = out.row(y);
    for (std::size_t x = 0; x < to.size(); ++x) {
      const std::int32_t value = from[x];
      const std::size_t level = static_cast<std::size_t>(std::min(value >> kGreyBits, 255));
      const std::int32_t noise = dsp::round_shift(sigma[level] * gaussian.next(), kGaussianBits);
      to[x] =
          static_cast<std::uint8_t>(std::clamp(dsp::round_shift(value + noise, kGreyBits), 0, 255));
    }
  }
}

}  // namespace stof::hal::emu
