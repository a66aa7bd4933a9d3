#include "hal/emu/imagery/replay.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace stof::hal::emu {
namespace {

template <typename T>
void copy_pixels(dsp::ImageView<const T> from, dsp::ImageView<T> to) noexcept {
  STOF_CHECK(dsp::same_size(from, to));
  for (int y = 0; y < to.height(); ++y) {
    std::ranges::copy(from.row(y), to.row(y).begin());
  }
}

dsp::StereoRig assumed_rig(const dataset::StereoScene& scene) {
  const double width = scene.left.width;
  return {.left = {.width = scene.left.width,
                   .height = scene.left.height,
                   .fx = width,
                   .fy = width,
                   .cx = (width - 1) / 2,
                   .cy = (scene.left.height - 1) / 2.0},
          .baseline_m = Replay::kAssumedBaseline,
          .doff_px = 0};
}

}  // namespace

dataset::Loaded<std::unique_ptr<Replay>> Replay::open(
    const std::filesystem::path& dir, const std::optional<std::filesystem::path>& pmd_prefix) {
  dataset::Loaded<dataset::StereoScene> scene = dataset::read_stereo_scene(dir);
  if (!scene) {
    return std::unexpected(scene.error());
  }
  if (!pmd_prefix) {
    return std::unique_ptr<Replay>(new Replay(std::move(*scene), std::nullopt));
  }
  dataset::Loaded<dataset::PmdRecording> pmd = dataset::read_pmd(*pmd_prefix);
  if (!pmd) {
    return std::unexpected(pmd.error());
  }
  if (!pmd->has_rig) {
    return std::unexpected(dataset::Problem{
        pmd_prefix->string() +
        ".json: has no rig (stereo, R, T): use a recording that was made for " + dir.string()});
  }
  // The recording names no picture size; its principal point tells pictures that are not its own.
  const dsp::Pinhole& lens = pmd->calibration.stereo.left;
  if (lens.cx < 0 || lens.cx > scene->left.width || lens.cy < 0 || lens.cy > scene->left.height) {
    return std::unexpected(dataset::Problem{
        pmd_prefix->string() + ".json: its stereo camera's centre lies outside the images of " +
        dir.string() + ": use the recording that was made for them"});
  }
  return std::unique_ptr<Replay>(new Replay(std::move(*scene), std::move(*pmd)));
}

Replay::Replay(dataset::StereoScene scene, std::optional<dataset::PmdRecording> pmd)
    : scene_(std::move(scene)), pmd_(std::move(pmd)) {
  if (pmd_) {
    calibration_ = pmd_->calibration;
  } else {
    calibration_.stereo = scene_.rig.value_or(assumed_rig(scene_));
  }
  calibration_.stereo.left.width = scene_.left.width;
  calibration_.stereo.left.height = scene_.left.height;
}

Size Replay::stereo_size() const noexcept { return {scene_.left.width, scene_.left.height}; }

Size Replay::pmd_size() const noexcept {
  return pmd_ ? Size{pmd_->calibration.pmd.lens.width, pmd_->calibration.pmd.lens.height} : Size{};
}

void Replay::left(std::uint32_t /*number*/, dsp::ImageView<std::uint8_t> out) noexcept {
  copy_pixels(std::as_const(scene_).left.view(), out);
}

void Replay::right(std::uint32_t /*number*/, dsp::ImageView<std::uint8_t> out) noexcept {
  copy_pixels(std::as_const(scene_).right.view(), out);
}

void Replay::pmd(std::uint32_t number, int index, dsp::ImageView<std::uint16_t> out) noexcept {
  STOF_CHECK(pmd_.has_value() && index >= 0 && index < 4);
  const std::size_t count = pmd_->frames.size();
  // Exposures count from 1: the first one is frame 0; 0, before it, is the last.
  const std::size_t frame = (number % count + count - 1) % count;
  copy_pixels(pmd_->samples(frame)[static_cast<std::size_t>(index)], out);
}

std::optional<dataset::Image<float>> Replay::depth() const {
  if (!scene_.truth) {
    return std::nullopt;
  }
  const dsp::StereoRig& rig = calibration_.stereo;
  dataset::Image<float> out = *scene_.truth;
  for (float& pixel : out.pixels) {
    const double shift = static_cast<double>(pixel) + rig.doff_px;
    pixel = shift > 0 ? static_cast<float>(rig.left.fx * rig.baseline_m / shift)
                      : std::numeric_limits<float>::infinity();
    // Unknown disparity is +inf: not the depth 0 that the formula gives.
    if (pixel == 0) {
      pixel = std::numeric_limits<float>::infinity();
    }
  }
  return out;
}

}  // namespace stof::hal::emu
