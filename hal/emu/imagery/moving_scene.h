#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "dataset/dataset.h"
#include "hal/emu/imagery/imagery.h"
#include "hal/emu/imagery/sensors.h"
#include "hal/emu/scenes/rig.h"
#include "hal/emu/scenes/scene.h"

namespace stof::hal::emu {

// Something that moves through a scene, round and round.
struct Motion {
  Scene background;
  std::vector<std::vector<SceneObject>> poses;  // what moves, at least one pose
  int exposures_per_pose = 3;  // a pose stands still for as many exposures of the stereo camera
  int pmd_every = 1;           // the PMD camera exposes at every so many of these
};

// The corridor, in which a person walks round in 4 s at 30 exposures a second, 10 poses a second:
// towards the cameras to 2.6 m, back to 5.2 m, 0.64 m across.
Motion walking();

// The corridor without the person: a box before a door; the box alone is taken away; the door is
// open. 12 exposures each, round and round.
Motion leaving();

// A picture of which each pose replaces a part.
template <typename T>
class Poses {
 public:
  // The next pose: what `picture` shows in runs[y] of every row.
  void add(std::vector<Run> runs, const dataset::Image<T>& picture);
  // Makes `shown`, which shows the background and the pose that was asked for last, show `pose`.
  void show(std::size_t pose, const dataset::Image<T>& background,
            dataset::Image<T>& shown) noexcept;

 private:
  struct Part {
    std::vector<Run> runs;
    std::vector<T> pixels;  // run after run
  };
  std::vector<Part> parts_;
  std::optional<std::size_t> last_;
};

// A scene in motion as a rig sees it. The constructor renders all poses without noise, of each what
// differs from the background; an exposure of another pose copies that in place, and adds its own
// noise. Within an exposure nothing moves.
class MovingScene final : public SensorImagery {
 public:
  MovingScene(const Motion& motion, const Rig& rig);
  void left(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept override;
  void right(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept override;
  void pmd(std::uint32_t number, int index, dsp::ImageView<std::uint16_t> out) noexcept override;

  // The scene of exposure `number` of the stereo camera, which is exposure
  // (number - 1) / pmd_every + 1 of the PMD camera.
  Scene scene(std::uint32_t number) const;
  dataset::Image<float> depth(std::uint32_t number) const override;
  dataset::Image<std::uint8_t> visible(std::uint32_t number) const override;

 private:
  std::size_t pose_of(std::uint32_t number) const noexcept;

  Motion motion_;
  CleanViews background_;
  CleanViews shown_;
  Poses<std::uint16_t> left_;
  Poses<std::uint16_t> right_;
  Poses<std::int32_t> pmd_mean_;
  Poses<std::uint16_t> pmd_sigma_;
};

}  // namespace stof::hal::emu
