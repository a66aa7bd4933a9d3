#include "hal/emu/imagery/pmd_samples.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "dsp/base/fixed.h"
#include "dsp/base/random.h"
#include "hal/emu/imagery/noise.h"
#include "hal/emu/imagery/phasor.h"
#include "hal/emu/imagery/soften.h"

namespace stof::hal::emu {
namespace {

// What one pixel collects before the samples differ: electrons.
struct Collected {
  double signal = 0;
  double ambient = 0;
  // Sum of s e^(h j phase), h = 1, 3, 5.
  Phasor first;
  Phasor third;
  Phasor fifth;
};

double half_power(double base, int half_powers) noexcept {
  double out = half_powers % 2 == 0 ? 1 : std::sqrt(base);
  for (int i = 0; i < half_powers / 2; ++i) {
    out *= base;
  }
  return out;
}

class PmdRenderer {
 public:
  PmdRenderer(const Scene& scene, const Viewpoint& viewpoint, const PmdCameraModel& camera)
      : scene_(scene),
        viewpoint_(viewpoint),
        model_(camera.model),
        rays_(camera.rays),
        turns_per_metre_(camera.modulation.value / dsp::kLightMetresPerSecond) {}

  Collected pixel(std::size_t index) const {
    const std::size_t count = static_cast<std::size_t>(model_.rays_per_side) *
                              static_cast<std::size_t>(model_.rays_per_side);
    Collected sum;
    for (const Vec3& ray : rays_.subspan(index * count, count)) {
      add(ray, sum);
    }
    return sum;
  }

 private:
  // What the ray meets, and what is behind it where that is a pane: light comes and goes through
  // it.
  void add(const Vec3& ray, Collected& sum) const {
    const Hit hit = viewpoint_.look(ray.x, ray.y);
    if (hit.object < 0) {
      return;
    }
    add(ray, hit, 1, sum);
    const double transmittance = material_of(hit).transmittance;
    if (transmittance > 0) {
      const Hit behind = viewpoint_.look_past(hit.object, ray.x, ray.y);
      if (behind.object >= 0) {
        add(ray, behind, transmittance * transmittance, sum);
      }
    }
  }

  // `through`: the share of the light that is left on its way.
  void add(const Vec3& ray, const Hit& hit, double through, Collected& sum) const {
    const double share = through * infrared_albedo(material_of(hit), hit.local) /
                         (model_.rays_per_side * model_.rays_per_side);
    sum.ambient += model_.ambient_e * share;
    const Vec3 point = hit.t * ray;
    const double back = length(point);
    const double field = 1 / length(ray);  // cosine
    const Vec3 normal = viewpoint_.pose().turn_back(hit.normal);
    for (const Vec3& emitter : model_.emitters) {
      const Vec3 path = point - emitter;
      const double out = length(path);
      const double emission = path.z / out;
      const double incidence = -dot(normal, path) / out;
      if (emission <= 0 || incidence <= 0) {
        continue;
      }
      const double signal = model_.signal_e * share / static_cast<double>(model_.emitters.size()) *
                            half_power(emission, model_.beam_half_powers) * incidence * field *
                            field * field * field / (out * out);
      const Phasor phase = phasor(turns_per_metre_ * (out + back));
      const Phasor twice = phase * phase;
      const Phasor third = twice * phase;
      sum.signal += signal;
      sum.first = sum.first + signal * phase;
      sum.third = sum.third + signal * third;
      sum.fifth = sum.fifth + signal * (third * twice);
    }
  }

  const Material& material_of(const Hit& hit) const {
    return scene_.objects[static_cast<std::size_t>(hit.object)].material;
  }

  const Scene& scene_;
  const Viewpoint& viewpoint_;
  const PmdModel& model_;
  std::span<const Vec3> rays_;
  double turns_per_metre_;
};

// D_k: the real part of every harmonic, turned by h k quarter turns. The pixel's offset turns the
// phase that will be measured, I + jQ ~ e^j + kappa3 e^-3j + kappa5 e^5j, as a whole.
double correlation(const Collected& c, int k, const PmdModel& model,
                   const Phasor& offset) noexcept {
  const Phasor first = c.first * offset * phasor(k / 4.0);
  const Phasor third = c.third * offset.conjugate() * phasor(3 * k / 4.0);
  const Phasor fifth = c.fifth * offset * phasor(5 * k / 4.0);
  return model.contrast * (first.re + model.kappa3 * third.re + model.kappa5 * fifth.re);
}

// What light inside of the camera adds to a sample, electrons.
struct Stray {
  double light = 0;
  Phasor phase;  // times its amplitude
};

Stray stray_of(const PmdModel& model, dsp::Hertz modulation) noexcept {
  if (model.stray_e == 0) {
    return {};
  }
  const double turns = 2 * model.stray_m * modulation.value / dsp::kLightMetresPerSecond;
  return {.light = model.stray_e / model.contrast, .phase = model.stray_e * phasor(turns)};
}

}  // namespace

namespace {

// Where the rays of a blurred pixel start along one side, counted from its centre: the quantiles of
// what a Gaussian makes of the pixel, stretched to its exact variance.
std::vector<double> blurred_starts(int count, double blur_px) {
  std::vector<double> out;
  out.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    out.push_back((i + 0.5) / count);
  }
  constexpr int kSteps = 4096;
  constexpr double kReach = 4;  // standard deviations of the Gaussian beyond the pixel
  const double end = 0.5 + kReach * blur_px;
  std::vector<double> area(kSteps + 1, 0.0);  // up to each step
  for (std::size_t i = 1; i <= kSteps; ++i) {
    const double x = -end + 2 * end * (static_cast<double>(i) - 0.5) / kSteps;
    area[i] = area[i - 1] + blurred_pixel(x, blur_px);
  }
  double square = 0;
  std::size_t at = 0;
  for (double& place : out) {
    const double wanted = place * area.back();
    while (area[at + 1] < wanted) {
      ++at;
    }
    const double inside = (wanted - area[at]) / (area[at + 1] - area[at]);
    place = -end + 2 * end * (static_cast<double>(at) + inside) / kSteps;
    square += place * place / count;
  }
  const double stretch = count == 1 ? 0 : std::sqrt((1.0 / 12 + blur_px * blur_px) / square);
  for (double& place : out) {
    place *= stretch;
  }
  return out;
}

// Where a share of the light along one side starts, counted from the pixel's centre. share: 0..1.
class Starts {
 public:
  explicit Starts(double blur_px)
      : quantiles_(blur_px > 0 ? blurred_starts(kQuantiles, blur_px) : std::vector<double>()) {}

  double at(double share) const {
    if (quantiles_.empty()) {
      return share - 0.5;
    }
    const double place = std::clamp(share * kQuantiles - 0.5, 0.0, kQuantiles - 1.0);
    const auto before = std::min(static_cast<std::size_t>(place), std::size_t{kQuantiles - 2});
    const double part = place - static_cast<double>(before);
    return (1 - part) * quantiles_[before] + part * quantiles_[before + 1];
  }

 private:
  static constexpr int kQuantiles = 1024;
  std::vector<double> quantiles_;
};

// The step of a lattice of so many points whose rows are far apart whichever way one looks: without
// a common factor, near to the golden section.
int lattice_step(int count) {
  constexpr double kGolden = 0.6180339887498949;
  int step = static_cast<int>(std::lround(kGolden * count));
  while (std::gcd(step, count) != 1) {
    ++step;
  }
  return step;
}

double fraction(double x) { return x - std::floor(x); }

std::vector<Vec3> scattered_rays(const dsp::Pinhole& lens, int count, double blur_px) {
  std::vector<Vec3> out;
  out.reserve(static_cast<std::size_t>(lens.width) * static_cast<std::size_t>(lens.height) *
              static_cast<std::size_t>(count));
  const Starts starts(blur_px);
  const int step = lattice_step(count);
  for (int y = 0; y < lens.height; ++y) {
    for (int x = 0; x < lens.width; ++x) {
      dsp::SplitMix64 random(static_cast<std::uint64_t>(y * lens.width + x));
      const double right = static_cast<double>(random.next() >> 11U) * 0x1p-53;
      const double down = static_cast<double>(random.next() >> 11U) * 0x1p-53;
      for (int i = 0; i < count; ++i) {
        const double u = fraction(static_cast<double>(i) / count + right);
        const double v = fraction(static_cast<double>(i * step % count) / count + down);
        out.push_back(undistorted_ray(lens, x + starts.at(u), y + starts.at(v)));
      }
    }
  }
  return out;
}

}  // namespace

std::vector<Vec3> pmd_rays(const dsp::Pinhole& lens, int rays_per_side, double blur_px,
                           RayPlaces places) {
  if (places == RayPlaces::kScattered) {
    return scattered_rays(lens, rays_per_side * rays_per_side, blur_px);
  }
  std::vector<Vec3> out;
  out.reserve(static_cast<std::size_t>(lens.width * rays_per_side) *
              static_cast<std::size_t>(lens.height * rays_per_side));
  const std::vector<double> offsets =
      blur_px > 0 ? blurred_starts(rays_per_side, blur_px) : std::vector<double>();
  for (int y = 0; y < lens.height; ++y) {
    for (int x = 0; x < lens.width; ++x) {
      for (int j = 0; j < rays_per_side; ++j) {
        for (int i = 0; i < rays_per_side; ++i) {
          if (!offsets.empty()) {
            out.push_back(undistorted_ray(lens, x + offsets[static_cast<std::size_t>(i)],
                                          y + offsets[static_cast<std::size_t>(j)]));
            continue;
          }
          const double u = x - 0.5 + (i + 0.5) / rays_per_side;
          const double v = y - 0.5 + (j + 0.5) / rays_per_side;
          out.push_back(undistorted_ray(lens, u, v));
        }
      }
    }
  }
  return out;
}

RayPlaces ray_places(const PmdModel& model) noexcept {
  return model.scattered_rays ? RayPlaces::kScattered : RayPlaces::kGrid;
}

void render_pmd(const Scene& scene, const Viewpoint& viewpoint, const PmdCameraModel& camera,
                std::span<const Run> runs, CleanSamples& out) {
  const PmdRenderer renderer(scene, viewpoint, camera);
  const PmdModel& model = camera.model;
  const int width = camera.lens.width;
  const int height = camera.lens.height;
  const double one = 1 << kPmdBits;
  const double turns = 2 * camera.offset_m * camera.modulation.value / dsp::kLightMetresPerSecond;
  const Stray stray = stray_of(model, camera.modulation);
  for (int y = 0; y < height; ++y) {
    const Run& run = runs[static_cast<std::size_t>(y)];
    for (int x = run.begin; x < run.end; ++x) {
      const std::size_t at = static_cast<std::size_t>(y * width + x);
      const Collected c = renderer.pixel(at);
      const double pattern = camera.pattern.empty() ? 0.0 : camera.pattern[at] / 65536.0;
      const Phasor offset = phasor(pattern + turns);
      for (int k = 0; k < 4; ++k) {
        const double light = c.signal + correlation(c, k, model, offset) +
                             (stray.light + (stray.phase * phasor(k / 4.0)).re);
        const double kept = light + (1 - model.suppression) * c.ambient + model.residual_e;
        const double variance = light + c.ambient + model.read_noise_e * model.read_noise_e;
        const double mean = kept / model.electrons_per_lsb + model.dark_lsb;
        const double sigma = std::sqrt(variance) / model.electrons_per_lsb;
        out.mean.view().at(x, k * height + y) =
            static_cast<std::int32_t>(std::floor(std::min(mean, 1e6) * one + 0.5));
        out.sigma.view().at(x, k * height + y) =
            static_cast<std::uint16_t>(std::min(std::floor(sigma * one + 0.5), 65535.0));
      }
    }
  }
}

CleanSamples render_pmd(const Scene& scene, const Viewpoint& viewpoint, const dsp::Pinhole& lens,
                        dsp::Hertz modulation, const PmdModel& model,
                        std::span<const std::int16_t> pattern) {
  CleanSamples out{.mean = {lens.width, 4 * lens.height}, .sigma = {lens.width, 4 * lens.height}};
  const std::vector<Vec3> rays =
      pmd_rays(lens, model.rays_per_side, model.blur_px, ray_places(model));
  render_pmd(
      scene, viewpoint,
      {.lens = lens, .modulation = modulation, .model = model, .rays = rays, .pattern = pattern},
      whole_picture(lens), out);
  return out;
}

std::vector<std::int16_t> make_pattern(const dsp::Pinhole& lens, dsp::Hertz modulation,
                                       const PmdModel& model, std::uint64_t seed) {
  const double turn_m = dsp::kLightMetresPerSecond / (2.0 * modulation.value);
  const double rms = model.pattern_rms_m / turn_m * 65536 / (1 << kGaussianBits);
  std::vector<std::int16_t> out(static_cast<std::size_t>(lens.width) *
                                static_cast<std::size_t>(lens.height));
  GaussianNoise gaussian(seed);
  for (std::int16_t& offset : out) {
    offset = static_cast<std::int16_t>(std::floor(rms * gaussian.next() + 0.5));
  }
  return out;
}

namespace {

// Electrons that one emitter brings back from a white surface, facing the lens at `point` on its
// axis.
Phasor white_echo(const Vec3& emitter, const PmdModel& model, double turns_per_metre) noexcept {
  const Vec3 point{0, 0, 1};
  const Vec3 path = point - emitter;
  const double out = length(path);
  const double cosine = path.z / out;  // of emission and of incidence
  return model.signal_e * half_power(cosine, model.beam_half_powers) * cosine / (out * out) *
         phasor(turns_per_metre * (out + length(point)));
}

double white_lsb(dsp::Hertz modulation, const PmdModel& model) noexcept {
  Phasor sum;
  for (const Vec3& emitter : model.emitters) {
    sum = sum + white_echo(emitter, model, modulation.value / dsp::kLightMetresPerSecond);
  }
  return model.contrast / model.electrons_per_lsb * std::sqrt(sum.re * sum.re + sum.im * sum.im) /
         static_cast<double>(model.emitters.size());
}

// A way out that is longer than the way back by e^2 / 2 z - e r moves the distance by half of it.
bool emitters_matter(const PmdModel& model) noexcept {
  constexpr double kNearest = 0.5;
  constexpr double kMatters = 0.001;
  Vec3 sum;
  double squares = 0;
  for (const Vec3& emitter : model.emitters) {
    sum = sum + emitter;
    squares += dot(emitter, emitter);
  }
  const double count = static_cast<double>(model.emitters.size());
  return squares / count / (4 * kNearest) + length(sum) / count / 2 >= kMatters;
}

}  // namespace

dsp::PmdSensor sensor_constants(const dsp::Pinhole& lens, dsp::Hertz modulation,
                                const PmdModel& model) {
  const Stray stray = stray_of(model, modulation);
  dsp::PmdSensor out{
      .lens = lens,
      .frequency = {.modulation = modulation,
                    .wiggling = dsp::wiggling_of_harmonics(model.kappa3, model.kappa5),
                    .stray_i_lsb = 2 * stray.phase.re / model.electrons_per_lsb,
                    .stray_q_lsb = 2 * stray.phase.im / model.electrons_per_lsb},
      .dark_lsb = model.dark_lsb,
      .saturation_lsb = (1 << model.bits) - 1,
      .electrons_per_lsb = model.electrons_per_lsb,
      .noise_lsb = model.read_noise_e / model.electrons_per_lsb,
      .suppressed_lsb = model.suppression * model.ambient_e / model.electrons_per_lsb,
      .white_lsb = white_lsb(modulation, model),
      .fixed_pattern = {}};
  if (emitters_matter(model) && model.emitters.size() <= out.emitters.size()) {
    for (const Vec3& emitter : model.emitters) {
      out.emitters[static_cast<std::size_t>(out.emitter_count++)] = {emitter.x, emitter.y,
                                                                     emitter.z};
    }
  }
  return out;
}

void expose_pmd(const CleanSamples& clean, int index, int max, std::uint64_t seed,
                dsp::ImageView<std::uint16_t> out) noexcept {
  STOF_CHECK(index >= 0 && index < 4 && out.width() == clean.mean.width &&
             4 * out.height() == clean.mean.height);
  GaussianNoise gaussian(seed);
  for (int y = 0; y < out.height(); ++y) {
    const std::span<const std::int32_t> mean = clean.mean.view().row(index * out.height() + y);
    const std::span<const std::uint16_t> sigma = clean.sigma.view().row(index * out.height() + y);
    const std::span<std::uint16_t> to = out.row(y);
    for (std::size_t x = 0; x < to.size(); ++x) {
      const std::int32_t noise = dsp::round_shift(sigma[x] * gaussian.next(), kGaussianBits);
      to[x] = static_cast<std::uint16_t>(
          std::clamp(dsp::round_shift(mean[x] + noise, kPmdBits), 0, max));
    }
  }
}

}  // namespace stof::hal::emu
