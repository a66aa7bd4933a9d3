#pragma once

#include <cstdint>
#include <vector>

#include "dataset/dataset.h"
#include "dsp/calib/calibration.h"
#include "hal/emu/imagery/lens_rays.h"
#include "hal/emu/scenes/rig.h"
#include "hal/emu/scenes/viewpoint.h"

// A grey camera: what it would show without noise, and the noise.
namespace stof::hal::emu {

inline constexpr int kGreyBits = 7;  // fraction bits of a noise-free level, 0 .. 2 * 255

// Renders without noise, as a sharp lens shows it. Where more than one surface meets a pixel it is
// the mean of 36 rays, on textured ones of 9, at edges of a print of 233.
dataset::Image<std::uint16_t> render_grey(const Scene& scene, const Viewpoint& viewpoint,
                                          const LensRays& rays, const GreyModel& model);
// A part of it: replaces the pixels of runs[y] in each row of `out`, which shows the same scene
// without object `first` and all after it.
void render_grey_over(const Scene& scene, const Viewpoint& viewpoint, const LensRays& rays,
                      const GreyModel& model, std::span<const Run> runs, int first,
                      dataset::Image<std::uint16_t>& out);

// Depth in metres at pixel centres, +inf = nothing there: Z, or along another direction of the
// viewpoint's frame.
dataset::Image<float> render_depth(const Viewpoint& viewpoint, const LensRays& rays,
                                   const Vec3& along = {0, 0, 1});

// Index of the object at pixel centres, -1 = nothing there.
dataset::Image<int> render_objects(const Viewpoint& viewpoint, const LensRays& rays);

// 255 where `other` sees the point that `viewpoint` sees at the pixel's centre, inside its picture.
dataset::Image<std::uint8_t> render_visible(const Viewpoint& viewpoint, const LensRays& rays,
                                            const Viewpoint& other, const dsp::Pinhole& other_lens);

// Standard deviation of the noise for each level 0..255, kGreyBits fraction bits.
std::vector<std::uint16_t> grey_noise(const GreyModel& model);

// out = clip(round(clean + sigma(clean) * normal numbers of `seed`)). Equal sizes.
void expose_grey(dsp::ImageView<const std::uint16_t> clean, std::span<const std::uint16_t> sigma,
                 std::uint64_t seed, dsp::ImageView<std::uint8_t> out) noexcept;

}  // namespace stof::hal::emu
