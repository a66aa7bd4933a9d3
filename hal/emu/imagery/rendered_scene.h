#pragma once

#include <cstdint>

#include "dataset/dataset.h"
#include "hal/emu/imagery/imagery.h"
#include "hal/emu/imagery/sensors.h"
#include "hal/emu/scenes/rig.h"
#include "hal/emu/scenes/scene.h"

namespace stof::hal::emu {

// A scene as a rig sees it. The constructor renders everything without noise (some 0.6 s for
// 640x480); an exposure adds its own noise only, about a millisecond.
class RenderedScene final : public SensorImagery {
 public:
  RenderedScene(const Scene& scene, const Rig& rig);

  void left(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept override;
  void right(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept override;
  void pmd(std::uint32_t number, int index, dsp::ImageView<std::uint16_t> out) noexcept override;

  // Z in metres of the left view at pixel centres, +inf = nothing there.
  const dataset::Image<float>& depth() const noexcept { return depth_; }
  // 255 = the right camera sees the same point, 0 = not.
  const dataset::Image<std::uint8_t>& visible() const noexcept { return visible_; }
  dataset::Image<float> depth(std::uint32_t) const override { return depth_; }
  dataset::Image<std::uint8_t> visible(std::uint32_t) const override { return visible_; }

 private:
  CleanViews views_;
  dataset::Image<float> depth_;
  dataset::Image<std::uint8_t> visible_;
};

}  // namespace stof::hal::emu
