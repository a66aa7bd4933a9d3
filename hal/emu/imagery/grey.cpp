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
constexpr double kMaxLevel = 2 * 255.0;

// A smooth surface of one object, or nothing.
struct Patch {
  int object = -1;
  int face = 0;
  friend bool operator==(const Patch&, const Patch&) = default;
};

class GreyRenderer {
 public:
  GreyRenderer(const Scene& scene, const Viewpoint& viewpoint, const dsp::Pinhole& lens)
      : scene_(scene), viewpoint_(viewpoint), lens_(lens) {}

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
    return viewpoint_.may_show(first, {.x_min = (x - 0.5 - lens_.cx) / lens_.fx,
                                       .x_max = (x + 0.5 - lens_.cx) / lens_.fx,
                                       .y_min = (y - 0.5 - lens_.cy) / lens_.fy,
                                       .y_max = (y + 0.5 - lens_.cy) / lens_.fy});
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
    const double albedo = mean(x, y, kTextureRays, [&](double rx, double ry) {
      const Hit hit = viewpoint_.look_at(centre.object, rx, ry);
      return visible_albedo(material, hit.object < 0 ? centre.local : hit.local);
    });
    return albedo * light.diffuse + light.mirrored;
  }

 private:
  Hit look(double u, double v) const {
    return viewpoint_.look((u - lens_.cx) / lens_.fx, (v - lens_.cy) / lens_.fy);
  }

  const Material& material_of(const Hit& hit) const {
    return scene_.objects[static_cast<std::size_t>(hit.object)].material;
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
        sum += value((u - lens_.cx) / lens_.fx, (v - lens_.cy) / lens_.fy);
      }
    }
    return sum / (side * side);
  }

  const Scene& scene_;
  const Viewpoint& viewpoint_;
  const dsp::Pinhole& lens_;
};

std::uint16_t level_of(double radiance, const GreyModel& model) noexcept {
  const double level = std::clamp(model.black + model.gain * radiance, 0.0, kMaxLevel);
  return static_cast<std::uint16_t>(std::floor(level * (1 << kGreyBits) + 0.5));
}

}  // namespace

void render_grey_over(const Scene& scene, const Viewpoint& viewpoint, const dsp::Pinhole& lens,
                      const GreyModel& model, std::span<const Run> runs, int first,
                      dataset::Image<std::uint16_t>& out) {
  const GreyRenderer renderer(scene, viewpoint, lens);
  Run last;  // what `below` belongs to
  std::vector<Patch> below;
  for (int y = 0; y < lens.height; ++y) {
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
                                          const dsp::Pinhole& lens, const GreyModel& model) {
  dataset::Image<std::uint16_t> out(lens.width, lens.height, level_of(0, model));
  render_grey_over(scene, viewpoint, lens, model, whole_picture(lens), 0, out);
  return out;
}

namespace {

// Of each pixel value(what its centre shows).
template <typename Pixel, typename Value>
dataset::Image<Pixel> map_of_centres(const Viewpoint& viewpoint, const dsp::Pinhole& lens,
                                     const Value& value) {
  dataset::Image<Pixel> out(lens.width, lens.height);
  for (int y = 0; y < lens.height; ++y) {
    for (int x = 0; x < lens.width; ++x) {
      out.view().at(x, y) = value(viewpoint.look((x - lens.cx) / lens.fx, (y - lens.cy) / lens.fy));
    }
  }
  return out;
}

}  // namespace

dataset::Image<float> render_depth(const Viewpoint& viewpoint, const dsp::Pinhole& lens) {
  return map_of_centres<float>(viewpoint, lens, [](const Hit& hit) {
    return hit.object < 0 ? std::numeric_limits<float>::infinity() : static_cast<float>(hit.t);
  });
}

dataset::Image<int> render_objects(const Viewpoint& viewpoint, const dsp::Pinhole& lens) {
  return map_of_centres<int>(viewpoint, lens, [](const Hit& hit) { return hit.object; });
}

dataset::Image<std::uint8_t> render_visible(const Viewpoint& viewpoint, const dsp::Pinhole& lens,
                                            const Viewpoint& other,
                                            const dsp::Pinhole& other_lens) {
  constexpr double kSame =
      1.001;  // the other viewpoint's ray ends at most 0.1 percent before the point
  dataset::Image<std::uint8_t> out(lens.width, lens.height);
  for (int y = 0; y < lens.height; ++y) {
    for (int x = 0; x < lens.width; ++x) {
      const Hit hit = viewpoint.look((x - lens.cx) / lens.fx, (y - lens.cy) / lens.fy);
      const Vec3 point = other.pose().undo(hit.point);
      if (hit.object < 0 || point.z <= 0) {
        continue;
      }
      const double rx = point.x / point.z;
      const double ry = point.y / point.z;
      const double u = rx * other_lens.fx + other_lens.cx;
      const double v = ry * other_lens.fy + other_lens.cy;
      const bool inside =
          u >= -0.5 && u <= other_lens.width - 0.5 && v >= -0.5 && v <= other_lens.height - 0.5;
      const Hit first = other.look(rx, ry);
      out.view().at(x, y) = inside && first.object >= 0 && first.t * kSame >= point.z ? 255 : 0;
    }
  }
  return out;
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
