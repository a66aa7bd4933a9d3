#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "dataset/dataset.h"
#include "dsp/calib/calibration.h"
#include "hal/emu/imagery/imagery.h"

namespace stof::hal::emu {

// A recorded scene in place of cameras: every exposure sees the same stereo pair, byte for byte,
// and the frames of the PMD recording one after the other, round and round.
class Replay final : public Imagery {
 public:
  // dir: a stereo scene; pmd_prefix: a PMD recording, none = a rig without PMD camera. Refused:
  // what dataset.h refuses, and a PMD recording that does not say where its camera was.
  static dataset::Loaded<std::unique_ptr<Replay>> open(
      const std::filesystem::path& dir, const std::optional<std::filesystem::path>& pmd_prefix);

  Size stereo_size() const noexcept override;
  Size pmd_size() const noexcept override;
  void left(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept override;
  void right(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept override;
  void pmd(std::uint32_t number, int index, dsp::ImageView<std::uint16_t> out) noexcept override;

  const std::string& name() const noexcept { return scene_.name; }
  // From the PMD recording, else from the stereo folder's meta.txt. Where neither has a rig, one is
  // assumed (kAssumedBaseline, focal length = image width); depth then has an arbitrary scale.
  const dsp::Calibration& calibration() const noexcept { return calibration_; }
  bool rig_is_assumed() const noexcept { return !pmd_ && !scene_.rig; }
  static constexpr double kAssumedBaseline = 0.16;  // metres
  int disparities() const noexcept { return scene_.ndisp; }
  // Z in metres of the left view by the calibration, +inf = unknown; none without ground truth.
  std::optional<dataset::Image<float>> depth() const;
  // 255 = known and seen by both cameras; none where the scene has no such mask.
  const std::optional<dataset::Image<std::uint8_t>>& visible() const noexcept {
    return scene_.visible;
  }

 private:
  Replay(dataset::StereoScene scene, std::optional<dataset::PmdRecording> pmd);

  dataset::StereoScene scene_;
  std::optional<dataset::PmdRecording> pmd_;
  dsp::Calibration calibration_;
};

}  // namespace stof::hal::emu
