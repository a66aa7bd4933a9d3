#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "dataset/dataset.h"
#include "dsp/calib/calibration.h"
#include "hal/emu/imagery/lens_rays.h"
#include "hal/emu/scenes/rig.h"
#include "hal/emu/scenes/viewpoint.h"

// A PMD camera: what its four samples would be without noise, and the noise. The model is
// PmdModel's.
namespace stof::hal::emu {

inline constexpr int kPmdBits = 6;  // fraction bits of a noise-free sample and of its noise

// Both hold A0..A3 stacked from top to bottom, width x 4 height, in LSB with kPmdBits fraction
// bits.
struct CleanSamples {
  dataset::Image<std::int32_t> mean;    // dark included, not clipped
  dataset::Image<std::uint16_t> sigma;  // of the noise
};

// Where the rays of a pixel start.
enum class RayPlaces : std::uint8_t {
  kGrid,  // row by row, alike in all pixels
  // A lattice, shifted in each pixel by lot. A pixel collects light from all of its area: what so
  // few rays make of an edge's share is off, in a grid by the same all along an upright edge, here
  // by chance.
  kScattered,
};

// The directions of every ray of a picture: of pixel after pixel, rays_per_side^2 each. With blur
// they start further out, as a Gaussian point spread of that standard deviation spreads the light
// that a pixel collects.
std::vector<Vec3> pmd_rays(const dsp::Pinhole& lens, int rays_per_side, double blur_px = 0,
                           RayPlaces places = RayPlaces::kGrid);

RayPlaces ray_places(const PmdModel& model) noexcept;

// A PMD camera that looks at scenes. Pattern: distance offset of each pixel in 1/65536 turn, row by
// row, or empty; offset_m: what every pixel measures too much.
struct PmdCameraModel {
  const dsp::Pinhole& lens;
  dsp::Hertz modulation;
  const PmdModel& model;
  std::span<const Vec3> rays;
  std::span<const std::int16_t> pattern;
  double offset_m = 0;
};

// Replaces the pixels of runs[y] in each row of all four samples.
void render_pmd(const Scene& scene, const Viewpoint& viewpoint, const PmdCameraModel& camera,
                std::span<const Run> runs, CleanSamples& out);

// A whole picture.
CleanSamples render_pmd(const Scene& scene, const Viewpoint& viewpoint, const dsp::Pinhole& lens,
                        dsp::Hertz modulation, const PmdModel& model,
                        std::span<const std::int16_t> pattern);

// The offsets of a sensor: normal with model.pattern_rms_m.
std::vector<std::int16_t> make_pattern(const dsp::Pinhole& lens, dsp::Hertz modulation,
                                       const PmdModel& model, std::uint64_t seed);

// The constants of dsp::PmdSensor that describe this sensor exactly; the pattern is left empty.
// Emitters are named where they change a distance beyond 0.5 m by a millimetre or more. white_lsb
// leaves out the harmonics, which raise and lower an amplitude by up to kappa3 + kappa5.
dsp::PmdSensor sensor_constants(const dsp::Pinhole& lens, dsp::Hertz modulation,
                                const PmdModel& model);

// out = clip(round(mean + sigma * normal numbers of `seed`), 0, max), sample `index`, 0..3.
void expose_pmd(const CleanSamples& clean, int index, int max, std::uint64_t seed,
                dsp::ImageView<std::uint16_t> out) noexcept;

}  // namespace stof::hal::emu
