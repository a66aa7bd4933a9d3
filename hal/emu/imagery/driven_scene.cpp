#include "hal/emu/imagery/driven_scene.h"

#include <algorithm>
#include <utility>

#include "dsp/base/check.h"
#include "hal/emu/scenes/drive.h"

namespace stof::hal::emu {

DrivenScene::DrivenScene(Scene scene, const Rig& rig, double speed, const ExposureTimes& times)
    : SensorImagery(rig),
      scene_(std::move(scene)),
      start_(rig.left_camera_pose),
      speed_(speed),
      times_(times) {
  STOF_CHECK(speed >= 0 && speed <= kMaxDriveSpeed && times.pmd_every >= 1);
}

Scene DrivenScene::seen_after(double seconds) const {
  return moved(scene_, start_, drive(start_, speed_, seconds));
}

Scene DrivenScene::seen_by_pair(std::uint32_t number) const {
  return seen_after(number * times_.period + times_.pair / 2);
}

const CleanViews& DrivenScene::pair(std::uint32_t number) {
  if (pair_number_ != number) {
    sensors().render_pair(seen_by_pair(number), pair_);
    pair_number_ = number;
  }
  return pair_;
}

const CleanViews& DrivenScene::samples(std::uint32_t number) {
  if (samples_number_ == number) {
    return samples_;
  }
  const std::uint32_t edge =
      number == 0 ? 0 : (number - 1) * static_cast<std::uint32_t>(times_.pmd_every) + 1;
  for (int k = 0; k < 4; ++k) {
    const double middle = times_.pmd * (2 * k + 1) / 8;
    CleanSamples all = sensors().render_samples(seen_after(edge * times_.period + middle));
    if (k == 0) {
      samples_.pmd = std::move(all);
      continue;
    }
    const int height = pmd_size().height;
    for (int y = k * height; y < (k + 1) * height; ++y) {
      std::ranges::copy(all.mean.view().row(y), samples_.pmd.mean.view().row(y).begin());
      std::ranges::copy(all.sigma.view().row(y), samples_.pmd.sigma.view().row(y).begin());
    }
  }
  samples_number_ = number;
  return samples_;
}

void DrivenScene::left(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept {
  sensors().left(pair(number), number, out);
}

void DrivenScene::right(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept {
  sensors().right(pair(number), number, out);
}

void DrivenScene::pmd(std::uint32_t number, int index, dsp::ImageView<std::uint16_t> out) noexcept {
  sensors().pmd(samples(number), number, index, out);
}

dataset::Image<float> DrivenScene::depth(std::uint32_t number) const {
  return sensors().depth(seen_by_pair(number));
}

dataset::Image<std::uint8_t> DrivenScene::visible(std::uint32_t number) const {
  return sensors().visible(seen_by_pair(number));
}

}  // namespace stof::hal::emu
