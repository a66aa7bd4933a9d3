#pragma once

#include <array>
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

// Where that which moves in a pose is while the cameras expose.
struct WhileExposed {
  std::vector<std::vector<SceneObject>> pair;  // in equal parts of the pair's exposure
  // In the middle of each of the PMD's samples; empty: all four see the pose itself.
  std::array<std::vector<SceneObject>, 4> samples{};
};

// Something that moves through a scene, round and round.
struct Motion {
  Scene background;
  std::vector<std::vector<SceneObject>> poses;  // what moves, at least one pose
  int exposures_per_pose = 3;  // a pose stands still for as many exposures of the stereo camera
  int pmd_every = 1;           // the PMD camera exposes at every so many of these
  // The poses of one exposure after the other, in place of exposures_per_pose; empty: pose after
  // pose.
  std::vector<std::size_t> schedule{};
  // For each pose, or empty: nothing moves within an exposure. Of a pose that stands still `pair`
  // is empty.
  std::vector<WhileExposed> blurred{};
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
// noise. What moves within the exposure of the pair is blurred; the four samples of a PMD exposure
// then see four places, each as it is in its middle.
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
  void add_pose(std::size_t pose, const CleanViews& sharp);
  Parts render_blurred(const std::vector<SceneObject>& pose, const WhileExposed& moving,
                       CleanViews& views) const;
  Scene with(const std::vector<SceneObject>& objects) const;

  Motion motion_;
  CleanViews background_;
  CleanViews shown_;
  Poses<std::uint16_t> left_;
  Poses<std::uint16_t> right_;
  Poses<std::int32_t> pmd_mean_;
  Poses<std::uint16_t> pmd_sigma_;
};

}  // namespace stof::hal::emu
