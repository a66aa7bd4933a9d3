#pragma once

#include <cstdint>
#include <vector>

#include "dataset/dataset.h"
#include "dsp/calib/calibration.h"
#include "hal/emu/imagery.h"
#include "hal/emu/pmd_samples.h"
#include "hal/emu/rig.h"
#include "hal/emu/scene.h"

namespace stof::hal::emu {

// A scene as a rig sees it. The constructor renders everything without noise (some 0.6 s for
// 640x480); an exposure adds its own noise only, about a millisecond.
class RenderedScene final : public Imagery {
 public:
  RenderedScene(const Scene& scene, const Rig& rig);
  RenderedScene(const RenderedScene&) = delete;
  RenderedScene& operator=(const RenderedScene&) = delete;

  Size stereo_size() const noexcept override;
  Size pmd_size() const noexcept override;
  void left(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept override;
  void right(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept override;
  void pmd(std::uint32_t number, int index, dsp::ImageView<std::uint16_t> out) noexcept override;

  // The truth of this world: what a perfect calibration would find. Its fixed pattern lives here.
  const dsp::Calibration& calibration() const noexcept { return calibration_; }
  // Search range in px that holds the scene.
  int disparities() const noexcept { return disparities_; }
  // Z in metres of the left view at pixel centres, +inf = nothing there.
  const dataset::Image<float>& depth() const noexcept { return depth_; }
  // 255 = the right camera sees the same point, 0 = not.
  const dataset::Image<std::uint8_t>& visible() const noexcept { return visible_; }

 private:
  std::uint32_t seed_;
  int disparities_;
  dsp::Calibration calibration_;
  std::vector<std::int16_t> fixed_pattern_;
  dataset::Image<float> depth_;
  dataset::Image<std::uint8_t> visible_;
  // Without noise.
  dataset::Image<std::uint16_t> left_;
  dataset::Image<std::uint16_t> right_;
  CleanSamples pmd_;
  std::vector<std::uint16_t> grey_sigma_;
  int pmd_max_;
};

}  // namespace stof::hal::emu
