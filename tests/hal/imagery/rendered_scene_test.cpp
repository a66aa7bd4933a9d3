#include "hal/emu/imagery/rendered_scene.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

namespace stof::test {
namespace {

using namespace hal::emu;

// The corridor's rig with a quarter of its pixels a side.
Rig small_rig() {
  Rig rig = corridor_rig();
  for (dsp::Pinhole* const lens : {&rig.stereo.left, &rig.pmd_lens}) {
    lens->width /= 4;
    lens->height /= 4;
    lens->fx /= 4;
    lens->fy /= 4;
    lens->cx /= 4;
    lens->cy /= 4;
  }
  rig.pmd.rays_per_side = 2;
  rig.disparities /= 4;
  return rig;
}

RenderedScene& small_corridor() {
  static RenderedScene scene(corridor(), small_rig());
  return scene;
}

std::uint64_t hash(std::uint64_t state, std::uint64_t value) {  // FNV-1a, by words
  return (state ^ value) * 0x100000001B3ULL;
}

struct Exposed {
  dataset::Image<std::uint8_t> left;
  dataset::Image<std::uint8_t> right;
  std::array<dataset::Image<std::uint16_t>, 4> samples;
};

Exposed expose(RenderedScene& scene, std::uint32_t number) {
  const Size stereo = scene.stereo_size();
  const Size pmd = scene.pmd_size();
  Exposed out{
      .left = {stereo.width, stereo.height}, .right = {stereo.width, stereo.height}, .samples = {}};
  scene.left(number, out.left.view());
  scene.right(number, out.right.view());
  for (int k = 0; k < 4; ++k) {
    dataset::Image<std::uint16_t>& sample = out.samples[static_cast<std::size_t>(k)];
    sample = {pmd.width, pmd.height};
    scene.pmd(number, k, sample.view());
  }
  return out;
}

TEST(RenderedScene, ExposureIsAFunctionOfItsNumber) {
  RenderedScene& scene = small_corridor();
  const Exposed a = expose(scene, 7);
  const Exposed other = expose(scene, 8);
  const Exposed b = expose(scene, 7);
  EXPECT_EQ(a.left.pixels, b.left.pixels);
  EXPECT_EQ(a.right.pixels, b.right.pixels);
  EXPECT_NE(a.left.pixels, other.left.pixels);
  EXPECT_NE(a.right.pixels, other.right.pixels);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(a.samples[k].pixels, b.samples[k].pixels);
    EXPECT_NE(a.samples[k].pixels, other.samples[k].pixels);
  }
}

// The number was computed once; every compiler and processor must find it again. A change of the
// renderer or of the corridor changes it.
TEST(RenderedScene, GivesTheSameBitsOnEveryMachine) {
  const Exposed exposed = expose(small_corridor(), 7);
  std::uint64_t state = 0xCBF29CE484222325ULL;
  for (const std::uint8_t pixel : exposed.left.pixels) {
    state = hash(state, pixel);
  }
  for (const std::uint8_t pixel : exposed.right.pixels) {
    state = hash(state, pixel);
  }
  for (const auto& sample : exposed.samples) {
    for (const std::uint16_t pixel : sample.pixels) {
      state = hash(state, pixel);
    }
  }
  EXPECT_EQ(state, 5574317223113190901ULL);
}

TEST(RenderedScene, NoiseOfTheViewsIsNotTheSame) {
  Scene scene = wall(2);
  RenderedScene flat(scene, small_rig());
  const Exposed exposed = expose(flat, 1);
  EXPECT_NE(exposed.left.pixels, exposed.right.pixels);
  EXPECT_NE(exposed.samples[0].pixels, exposed.samples[2].pixels);
}

TEST(Corridor, IsClosedAndWithinTheSearchRange) {
  const RenderedScene& scene = small_corridor();
  const dsp::StereoRig& rig = scene.calibration().stereo;
  const auto [nearest, farthest] = std::ranges::minmax(scene.depth().pixels);
  EXPECT_GT(nearest, 1.9F);
  EXPECT_LT(farthest, 6.8F);
  EXPECT_LT(rig.left.fx * rig.baseline_m / static_cast<double>(nearest) - rig.doff_px,
            scene.disparities() - 1);
  const auto seen = std::ranges::count(scene.visible().pixels, 255);
  EXPECT_GT(seen, static_cast<std::ptrdiff_t>(scene.visible().pixels.size() * 8 / 10));
}

TEST(Corridor, CalibrationIsUsableAndWithinThePmdCamerasRange) {
  const RenderedScene& scene = small_corridor();
  EXPECT_STREQ(dsp::problem(scene.calibration()), "");
  EXPECT_EQ(scene.calibration().pmd.fixed_pattern.size(),
            static_cast<std::size_t>(scene.pmd_size().width * scene.pmd_size().height));
}

// What the appliance's user sees of it: phases that are the truth's, on most of the picture.
TEST(Corridor, PmdSamplesHoldTheTruthOfItsOwnRays) {
  const Rig rig = small_rig();
  RenderedScene& scene = small_corridor();
  const dsp::PmdSensor& sensor = scene.calibration().pmd;
  const Exposed exposed = expose(scene, 1);
  const Scene world = corridor();
  const std::array<double, 3>& t = rig.pmd_to_stereo.translation_m;
  const Viewpoint viewpoint(
      world, rig.left_camera_pose * Pose{rig.pmd_to_stereo.rotation, {t[0], t[1], t[2]}});
  int usable = 0;
  int near = 0;
  for (std::size_t i = 0; i < sensor.fixed_pattern.size(); ++i) {
    const auto value = [&](std::size_t k) {
      return static_cast<double>(exposed.samples[k].pixels[i]);
    };
    const double x = value(0) - value(2);
    const double y = value(3) - value(1);
    const double offset = (value(0) + value(1) + value(2) + value(3)) / 4 - sensor.dark_lsb;
    if (std::hypot(x, y) / 2 < sensor.frequency.min_modulation_ratio * offset) {
      continue;
    }
    ++usable;
    const std::size_t width = static_cast<std::size_t>(sensor.lens.width);
    const std::size_t column = i % width;
    const std::size_t row = i / width;
    const Vec3 ray =
        undistorted_ray(sensor.lens, static_cast<double>(column), static_cast<double>(row));
    const double truth = viewpoint.look(ray.x, ray.y).t * length(ray);
    const double turns = std::atan2(y, x) / 6.283185307179586;
    near += std::abs((turns < 0 ? turns + 1 : turns) * 7.4948 - truth) < 0.25 ? 1 : 0;
  }
  EXPECT_GT(usable, static_cast<int>(sensor.fixed_pattern.size() * 8 / 10));
  EXPECT_GT(near, usable * 9 / 10);  // the rest: edges and noise
}

TEST(Corridor, RigWithoutAPmdCameraHasNone) {
  Rig rig = small_rig();
  rig.pmd_lens = {};
  const RenderedScene scene(wall(2), rig);
  EXPECT_EQ(scene.pmd_size(), Size{});
  EXPECT_STREQ(dsp::problem(scene.calibration()), "");
}

}  // namespace
}  // namespace stof::test
