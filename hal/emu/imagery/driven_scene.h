#pragma once

#include <cstdint>

#include "dataset/dataset.h"
#include "hal/emu/imagery/sensors.h"
#include "hal/emu/scenes/rig.h"
#include "hal/emu/scenes/scene.h"

namespace stof::hal::emu {

// When the cameras of a rig expose, in seconds after an edge: the pair until `pair`, the PMD camera
// at every so many edges, a sample in each quarter until `pmd`.
struct ExposureTimes {
  double period = 1.0 / 30;
  double pair = 0.004;
  double pmd = 0.016;
  int pmd_every = 1;
};

// A scene through which the rig drives (drive.h): exposure n begins n periods after it began. Each
// picture is what stands before the camera in the middle of its own exposure, so that nothing is
// blurred, and the four samples of a PMD exposure see four places. Each new exposure is rendered,
// which takes as long as a RenderedScene and allocates: for emulated time.
class DrivenScene final : public SensorImagery {
 public:
  DrivenScene(Scene scene, const Rig& rig, double speed, const ExposureTimes& times);
  void left(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept override;
  void right(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept override;
  void pmd(std::uint32_t number, int index, dsp::ImageView<std::uint16_t> out) noexcept override;

  dataset::Image<float> depth(std::uint32_t number) const override;
  dataset::Image<std::uint8_t> visible(std::uint32_t number) const override;

 private:
  static constexpr std::int64_t kNothing = -1;
  Scene seen_after(double seconds) const;
  Scene seen_by_pair(std::uint32_t number) const;
  const CleanViews& pair(std::uint32_t number);
  const CleanViews& samples(std::uint32_t number);

  Scene scene_;
  Pose start_;
  double speed_;
  ExposureTimes times_;
  CleanViews pair_;
  CleanViews samples_;
  std::int64_t pair_number_ = kNothing;  // of what was rendered last
  std::int64_t samples_number_ = kNothing;
};

}  // namespace stof::hal::emu
