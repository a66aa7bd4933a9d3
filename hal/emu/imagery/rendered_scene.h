#pragma once

#include <cstdint>

#include "dataset/dataset.h"
#include "dsp/calib/calibration.h"
#include "hal/emu/imagery/imagery.h"
#include "hal/emu/imagery/sensors.h"
#include "hal/emu/scenes/rig.h"
#include "hal/emu/scenes/scene.h"

namespace stof::hal::emu {

// A scene as a rig sees it. The constructor renders everything without noise (some 0.6 s for
// 640x480); an exposure adds its own noise only, about a millisecond.
class RenderedScene final : public Imagery {
 public:
  RenderedScene(const Scene& scene, const Rig& rig);
  RenderedScene(const RenderedScene&) = delete;
  RenderedScene& operator=(const RenderedScene&) = delete;

  Size stereo_size() const noexcept override { return sensors_.stereo_size(); }
  Size pmd_size() const noexcept override { return sensors_.pmd_size(); }
  void left(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept override;
  void right(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept override;
  void pmd(std::uint32_t number, int index, dsp::ImageView<std::uint16_t> out) noexcept override;

  // The truth of this world but for Rig::misplacement. Its fixed pattern lives here.
  const dsp::Calibration& calibration() const noexcept { return sensors_.calibration(); }
  // Search range in px that holds the scene.
  int disparities() const noexcept { return sensors_.disparities(); }
  // Z in metres of the left view at pixel centres, +inf = nothing there.
  const dataset::Image<float>& depth() const noexcept { return depth_; }
  // 255 = the right camera sees the same point, 0 = not.
  const dataset::Image<std::uint8_t>& visible() const noexcept { return visible_; }

 private:
  Sensors sensors_;
  CleanViews views_;
  dataset::Image<float> depth_;
  dataset::Image<std::uint8_t> visible_;
};

}  // namespace stof::hal::emu
