#include <algorithm>
#include <cmath>

#include "hal/emu/imagery/rendered_scene.h"
#include "hal/emu/scenes/rig.h"
#include "hal/emu/scenes/scene.h"
#include "tests/bench/bench_work.h"

namespace stof::bench {
namespace {

// The value at (x, y) of `image`, between its pixels; borders replicate.
double sample(const dataset::Image<std::uint8_t>& image, double x, double y) {
  const double cx = std::clamp(x, 0.0, image.width - 1.0);
  const double cy = std::clamp(y, 0.0, image.height - 1.0);
  const int x0 = std::min(static_cast<int>(cx), std::max(image.width - 2, 0));
  const int y0 = std::min(static_cast<int>(cy), std::max(image.height - 2, 0));
  const double fx = cx - x0;
  const double fy = cy - y0;
  const auto at = [&](int u, int v) {
    return static_cast<double>(
        image.view().row_clamped(v)[static_cast<std::size_t>(std::min(u, image.width - 1))]);
  };
  return (at(x0, y0) * (1 - fx) + at(x0 + 1, y0) * fx) * (1 - fy) +
         (at(x0, y0 + 1) * (1 - fx) + at(x0 + 1, y0 + 1) * fx) * fy;
}

dataset::Image<std::uint8_t> resized(const dataset::Image<std::uint8_t>& image, int width,
                                     int height) {
  dataset::Image<std::uint8_t> out(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double u = (x + 0.5) * image.width / width - 0.5;
      const double v = (y + 0.5) * image.height / height - 0.5;
      out.view().at(x, y) = static_cast<std::uint8_t>(std::lround(sample(image, u, v)));
    }
  }
  return out;
}

}  // namespace

Pictures resized(const dataset::StereoScene& scene, int width, int height) {
  return {.name = scene.name,
          .left = resized(scene.left, width, height),
          .right = resized(scene.right, width, height)};
}

Pictures corridor_pictures(int width, int height) {
  hal::emu::Rig rig = hal::emu::corridor_rig();
  hal::emu::resize_stereo(rig, width, height);
  rig.pmd_lens.width = 0;  // no PMD camera
  rig.pmd_lens.height = 0;
  hal::emu::RenderedScene scene(hal::emu::corridor(), rig);
  Pictures pictures{.name = "corridor", .left = {width, height}, .right = {width, height}};
  scene.left(1, pictures.left.view());
  scene.right(1, pictures.right.view());
  return pictures;
}

}  // namespace stof::bench
