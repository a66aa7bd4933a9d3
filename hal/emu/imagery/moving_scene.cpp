#include "hal/emu/imagery/moving_scene.h"

#include <algorithm>
#include <utility>

#include "dsp/base/check.h"

namespace stof::hal::emu {
namespace {

// The same runs in each of the four samples, which lie one below the other.
std::vector<Run> four_times(const std::vector<Run>& runs) {
  std::vector<Run> out;
  for (int k = 0; k < 4; ++k) {
    out.insert(out.end(), runs.begin(), runs.end());
  }
  return out;
}

template <typename T>
std::span<T> of_row(dsp::ImageView<T> picture, std::size_t row, const Run& run) noexcept {
  if (run.end <= run.begin) {
    return {};
  }
  return picture.row(static_cast<int>(row))
      .subspan(static_cast<std::size_t>(run.begin), static_cast<std::size_t>(run.end - run.begin));
}

}  // namespace

template <typename T>
void Poses<T>::add(std::vector<Run> runs, const dataset::Image<T>& picture) {
  Part part{.runs = std::move(runs), .pixels = {}};
  for (std::size_t y = 0; y < part.runs.size(); ++y) {
    const std::span<const T> pixels = of_row(picture.view(), y, part.runs[y]);
    part.pixels.insert(part.pixels.end(), pixels.begin(), pixels.end());
  }
  parts_.push_back(std::move(part));
}

template <typename T>
void Poses<T>::show(std::size_t pose, const dataset::Image<T>& background,
                    dataset::Image<T>& shown) noexcept {
  if (last_ == pose) {
    return;
  }
  if (last_) {
    const std::vector<Run>& runs = parts_[*last_].runs;
    for (std::size_t y = 0; y < runs.size(); ++y) {
      std::ranges::copy(of_row(background.view(), y, runs[y]),
                        of_row(shown.view(), y, runs[y]).begin());
    }
  }
  const Part& part = parts_[pose];
  std::span<const T> pixels = part.pixels;
  for (std::size_t y = 0; y < part.runs.size(); ++y) {
    const std::span<T> to = of_row(shown.view(), y, part.runs[y]);
    std::ranges::copy(pixels.first(to.size()), to.begin());
    pixels = pixels.subspan(to.size());
  }
  last_ = pose;
}

MovingScene::MovingScene(const Motion& motion, const Rig& rig)
    : SensorImagery(rig),
      motion_(motion),
      background_(sensors().render(motion.background)),
      shown_(background_) {
  STOF_CHECK(!motion.poses.empty() && motion.exposures_per_pose >= 1 && motion.pmd_every >= 1);
  const int first = static_cast<int>(motion.background.objects.size());
  for (const std::vector<SceneObject>& pose : motion.poses) {
    Scene scene = motion.background;
    scene.objects.insert(scene.objects.end(), pose.begin(), pose.end());
    CleanViews views = background_;
    Parts parts = sensors().render_over(scene, first, views);
    left_.add(std::move(parts.left), views.left);
    right_.add(std::move(parts.right), views.right);
    pmd_mean_.add(four_times(parts.pmd), views.pmd.mean);
    pmd_sigma_.add(four_times(parts.pmd), views.pmd.sigma);
  }
}

std::size_t MovingScene::pose_of(std::uint32_t number) const noexcept {
  return number / static_cast<std::uint32_t>(motion_.exposures_per_pose) % motion_.poses.size();
}

void MovingScene::left(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept {
  left_.show(pose_of(number), background_.left, shown_.left);
  sensors().left(shown_, number, out);
}

void MovingScene::right(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept {
  right_.show(pose_of(number), background_.right, shown_.right);
  sensors().right(shown_, number, out);
}

void MovingScene::pmd(std::uint32_t number, int index, dsp::ImageView<std::uint16_t> out) noexcept {
  const std::uint32_t every = static_cast<std::uint32_t>(motion_.pmd_every);
  const std::size_t pose = pose_of(number == 0 ? 0 : (number - 1) * every + 1);
  pmd_mean_.show(pose, background_.pmd.mean, shown_.pmd.mean);
  pmd_sigma_.show(pose, background_.pmd.sigma, shown_.pmd.sigma);
  sensors().pmd(shown_, number, index, out);
}

Scene MovingScene::scene(std::uint32_t number) const {
  Scene out = motion_.background;
  const std::vector<SceneObject>& pose = motion_.poses[pose_of(number)];
  out.objects.insert(out.objects.end(), pose.begin(), pose.end());
  return out;
}

dataset::Image<float> MovingScene::depth(std::uint32_t number) const {
  return sensors().depth(scene(number));
}

dataset::Image<std::uint8_t> MovingScene::visible(std::uint32_t number) const {
  return sensors().visible(scene(number));
}

}  // namespace stof::hal::emu
