#include "hal/emu/imagery/moving_scene.h"

#include <algorithm>
#include <functional>
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
    : SensorImagery(rig), motion_(motion) {
  STOF_CHECK(!motion.poses.empty() && motion.exposures_per_pose >= 1 && motion.pmd_every >= 1);
  STOF_CHECK(motion.blurred.empty() || motion.blurred.size() == motion.poses.size());
  const CleanViews sharp = sensors().render_sharp(motion.background);
  background_ = sharp;
  sensors().finish(background_);
  shown_ = background_;
  for (std::size_t pose = 0; pose < motion_.poses.size(); ++pose) {
    add_pose(pose, sharp);
  }
}

void MovingScene::add_pose(std::size_t pose, const CleanViews& sharp) {
  const int first = static_cast<int>(motion_.background.objects.size());
  CleanViews views = sharp;
  const Parts parts = motion_.blurred.empty() || motion_.blurred[pose].pair.empty()
                          ? sensors().render_over(with(motion_.poses[pose]), first, views)
                          : render_blurred(motion_.poses[pose], motion_.blurred[pose], views);
  sensors().finish(views);
  left_.add(sensors().widened(parts.left), views.left);
  right_.add(sensors().widened(parts.right), views.right);
  pmd_mean_.add(four_times(parts.pmd), views.pmd.mean);
  pmd_sigma_.add(four_times(parts.pmd), views.pmd.sigma);
}

Scene MovingScene::with(const std::vector<SceneObject>& objects) const {
  Scene scene = motion_.background;
  scene.objects.insert(scene.objects.end(), objects.begin(), objects.end());
  return scene;
}

namespace {

void include(std::vector<Run>& all, const std::vector<Run>& more) {
  all.resize(more.size());
  for (std::size_t y = 0; y < more.size(); ++y) {
    Run& run = all[y];
    if (more[y].end > more[y].begin) {
      run = run.end > run.begin
                ? Run{std::min(run.begin, more[y].begin), std::max(run.end, more[y].end)}
                : more[y];
    }
  }
}

void add_to(std::vector<std::uint32_t>& sums, const dataset::Image<std::uint16_t>& picture) {
  sums.resize(picture.pixels.size());
  std::ranges::transform(sums, picture.pixels, sums.begin(), std::plus<>());
}

void put_mean(const std::vector<std::uint32_t>& sums, std::size_t count,
              dataset::Image<std::uint16_t>& out) {
  std::ranges::transform(sums, out.pixels.begin(), [count](std::uint32_t sum) {
    return static_cast<std::uint16_t>((sum + count / 2) / count);
  });
}

}  // namespace

// The mean of the pair's parts; of each sample its own place.
Parts MovingScene::render_blurred(const std::vector<SceneObject>& pose, const WhileExposed& moving,
                                  CleanViews& views) const {
  const int first = static_cast<int>(motion_.background.objects.size());
  const CleanViews still = views;
  Parts parts;
  std::vector<std::uint32_t> left;
  std::vector<std::uint32_t> right;
  for (const std::vector<SceneObject>& objects : moving.pair) {
    CleanViews now{.left = still.left, .right = still.right, .pmd = {}};
    const Parts of = sensors().render_pair_over(with(objects), first, now);
    include(parts.left, of.left);
    include(parts.right, of.right);
    add_to(left, now.left);
    add_to(right, now.right);
  }
  put_mean(left, moving.pair.size(), views.left);
  put_mean(right, moving.pair.size(), views.right);
  const int height = pmd_size().height;
  if (moving.samples[0].empty() && height > 0) {
    parts.pmd = sensors().render_samples_over(with(pose), first, views.pmd);
    return parts;
  }
  for (int k = 0; k < 4 && height > 0; ++k) {
    CleanSamples now = still.pmd;
    include(parts.pmd, sensors().render_samples_over(
                           with(moving.samples[static_cast<std::size_t>(k)]), first, now));
    for (int y = k * height; y < (k + 1) * height; ++y) {
      std::ranges::copy(now.mean.view().row(y), views.pmd.mean.view().row(y).begin());
      std::ranges::copy(now.sigma.view().row(y), views.pmd.sigma.view().row(y).begin());
    }
  }
  return parts;
}

std::size_t MovingScene::pose_of(std::uint32_t number) const noexcept {
  if (!motion_.schedule.empty()) {
    return motion_.schedule[number % motion_.schedule.size()];
  }
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
  return with(motion_.poses[pose_of(number)]);
}

dataset::Image<float> MovingScene::depth(std::uint32_t number) const {
  return sensors().depth(scene(number));
}

dataset::Image<std::uint8_t> MovingScene::visible(std::uint32_t number) const {
  return sensors().visible(scene(number));
}

}  // namespace stof::hal::emu
