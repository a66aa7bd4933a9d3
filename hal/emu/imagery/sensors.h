#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "dataset/dataset.h"
#include "dsp/calib/calibration.h"
#include "hal/emu/imagery/imagery.h"
#include "hal/emu/imagery/pmd_samples.h"
#include "hal/emu/scenes/rig.h"
#include "hal/emu/scenes/scene.h"
#include "hal/emu/scenes/viewpoint.h"

namespace stof::hal::emu {

// The pictures of a scene by the cameras of a rig, without noise.
struct CleanViews {
  dataset::Image<std::uint16_t> left;
  dataset::Image<std::uint16_t> right;
  CleanSamples pmd;  // 0x0: no PMD camera
};

// A part of each picture: runs[y] of every row.
struct Parts {
  std::vector<Run> left;
  std::vector<Run> right;
  std::vector<Run> pmd;  // of each of the four samples
};

// The cameras of a rig: pictures of any scene, the noise of each exposure, the calibration.
class Sensors {
 public:
  explicit Sensors(const Rig& rig);
  Sensors(const Sensors&) = delete;
  Sensors& operator=(const Sensors&) = delete;

  // The rig's calibration: the truth of its world but for Rig::misplacement and Rig::published. Its
  // fixed pattern lives here.
  const dsp::Calibration& calibration() const noexcept { return calibration_; }
  // Search range in px that holds the scene the rig was made for.
  int disparities() const noexcept { return rig_.disparities; }
  Size stereo_size() const noexcept;
  Size pmd_size() const noexcept;

  CleanViews render(const Scene& scene) const;
  // Parts of that: the pictures of the pair, put into `views`; the samples of the PMD camera, which
  // the rig has.
  void render_pair(const Scene& scene, CleanViews& views) const;
  CleanSamples render_samples(const Scene& scene) const;

  // The same in steps: as sharp lenses show it, then what the lenses do to a whole picture.
  CleanViews render_sharp(const Scene& scene) const;
  void finish(CleanViews& views) const;
  // Where sharp pictures of the scene differ from those of the same scene without object `first`
  // and all after it. Renders these parts over sharp `views` of the latter.
  Parts render_over(const Scene& scene, int first, CleanViews& views) const;
  Parts render_pair_over(const Scene& scene, int first, CleanViews& views) const;
  std::vector<Run> render_samples_over(const Scene& scene, int first, CleanSamples& samples) const;
  // How far that part of a picture of the pair reaches once it is finished.
  std::vector<Run> widened(const std::vector<Run>& runs) const;

  // Z in metres of the left view, once it is rectified, at pixel centres, +inf = nothing there; of
  // a converging pair of the left view as it is, Z along the axes of the rig.
  dataset::Image<float> depth(const Scene& scene) const;
  // 255 = the right camera sees the same point, 0 = not.
  dataset::Image<std::uint8_t> visible(const Scene& scene) const;

  // Exposure `number` of what the views show.
  void left(const CleanViews& views, std::uint32_t number,
            dsp::ImageView<std::uint8_t> out) const noexcept;
  void right(const CleanViews& views, std::uint32_t number,
             dsp::ImageView<std::uint8_t> out) const noexcept;
  void pmd(const CleanViews& views, std::uint32_t number, int index,
           dsp::ImageView<std::uint16_t> out) const noexcept;

 private:
  Viewpoint left_viewpoint(const Scene& scene) const;
  Viewpoint right_viewpoint(const Scene& scene) const;
  Viewpoint pmd_viewpoint(const Scene& scene) const;
  PmdCameraModel pmd_camera() const noexcept;

  Rig rig_;
  Eye left_eye_;
  Eye right_eye_;
  LensRays left_rays_;
  LensRays right_rays_;
  std::vector<std::int16_t> fixed_pattern_;
  std::vector<Vec3> pmd_rays_;
  std::vector<Vec3> pmd_centres_;
  std::vector<std::uint16_t> grey_sigma_;
  dsp::Calibration calibration_;
};

// Imagery of what the sensors of a rig see, with its truth.
class SensorImagery : public Imagery {
 public:
  explicit SensorImagery(const Rig& rig) : sensors_(rig) {}

  Size stereo_size() const noexcept final { return sensors_.stereo_size(); }
  Size pmd_size() const noexcept final { return sensors_.pmd_size(); }
  // As Sensors has it.
  const dsp::Calibration& calibration() const noexcept { return sensors_.calibration(); }
  int disparities() const noexcept { return sensors_.disparities(); }

  // As Sensors has them, for exposure `number` of the stereo camera. They allocate, and may render.
  virtual dataset::Image<float> depth(std::uint32_t number) const = 0;
  virtual dataset::Image<std::uint8_t> visible(std::uint32_t number) const = 0;

 protected:
  const Sensors& sensors() const noexcept { return sensors_; }

 private:
  Sensors sensors_;
};

}  // namespace stof::hal::emu
