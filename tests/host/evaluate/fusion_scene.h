#pragma once

#include <cmath>
#include <numbers>

#include "dataset/dataset.h"
#include "tests/support/random.h"

// A small pair and a small PMD recording that see a wall at 2 m.
namespace stof::test {

// 40x30 random texture whose right view is moved by `shift`; truth and 8 candidates.
inline dataset::StereoScene shifted_scene(int shift = 3) {
  constexpr int kWidth = 40;
  constexpr int kHeight = 30;
  dataset::StereoScene scene;
  scene.name = "Wall & co";
  scene.ndisp = 8;
  scene.left = {kWidth, kHeight};
  scene.right = {kWidth, kHeight};
  scene.truth.emplace(kWidth, kHeight, static_cast<float>(shift));
  Random random(7);
  dataset::Image<std::uint8_t> texture(kWidth + shift, kHeight);
  random.fill(std::span(texture.pixels), 0, 255);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      scene.left.view().at(x, y) = texture.view().at(x, y);
      scene.right.view().at(x, y) = texture.view().at(x + shift, y);
    }
  }
  return scene;
}

// A 4x2 camera in the left camera's place that reads one radial distance everywhere. With its rig
// 3 px are 2 m.
inline dataset::PmdRecording flat_recording(double metres) {
  dataset::PmdRecording recording;
  dsp::Calibration& calibration = recording.calibration;
  calibration.pmd.lens = {.width = 4, .height = 2, .fx = 5, .fy = 5, .cx = 1.5, .cy = 0.5};
  calibration.pmd.dark_lsb = 100;
  calibration.stereo.left = {.width = 40, .height = 30, .fx = 60, .fy = 60, .cx = 19.5, .cy = 14.5};
  calibration.stereo.baseline_m = 0.1;
  recording.has_rig = true;
  const double turns = metres * 2 * calibration.pmd.frequency.modulation.value / 299792458.0;
  dataset::Image<std::uint16_t>& frame = recording.frames.emplace_back(4, 8);
  for (int k = 0; k < 4; ++k) {
    const double value = 1100 + 500 * std::cos(2 * std::numbers::pi * (turns + k / 4.0));
    for (int i = 0; i < 8; ++i) {
      frame.pixels[static_cast<std::size_t>(8 * k + i)] =
          static_cast<std::uint16_t>(std::lround(value));
    }
  }
  return recording;
}

}  // namespace stof::test
