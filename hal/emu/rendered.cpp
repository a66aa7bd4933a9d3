#include "hal/emu/rendered.h"

#include "hal/emu/eye.h"
#include "hal/emu/grey.h"
#include "hal/emu/random.h"

namespace stof::hal::emu {
namespace {

// Every sensor, exposure and sample has its own stream of noise.
enum Stream : std::uint32_t { kLeft = 0, kRight = 1, kPmd = 2, kPattern = 6 };

std::uint64_t stream_seed(std::uint32_t rig_seed, std::uint32_t number,
                          std::uint32_t stream) noexcept {
  return mix(mix(rig_seed) + number) + stream;
}

dsp::Pinhole right_lens(const dsp::StereoRig& rig) noexcept {
  dsp::Pinhole lens = rig.left;
  lens.cx += rig.doff_px;
  return lens;
}

Pose as_pose(const dsp::RigidTransform& transform) noexcept {
  const std::array<double, 3>& t = transform.translation_m;
  return {transform.rotation, {t[0], t[1], t[2]}};
}

}  // namespace

RenderedScene::RenderedScene(const Scene& scene, const Rig& rig)
    : seed_(rig.seed), disparities_(rig.disparities), pmd_max_((1 << rig.pmd.bits) - 1) {
  const dsp::Pinhole& left_lens = rig.stereo.left;
  const Eye left_eye(scene, rig.head);
  const Eye right_eye(scene, rig.head * Pose{.position = {rig.stereo.baseline_m, 0, 0}});
  left_ = render_grey(scene, left_eye, left_lens, rig.grey);
  right_ = render_grey(scene, right_eye, right_lens(rig.stereo), rig.grey);
  depth_ = render_depth(left_eye, left_lens);
  visible_ = render_visible(left_eye, left_lens, right_eye, right_lens(rig.stereo));
  grey_sigma_ = grey_noise(rig.grey);
  calibration_.stereo = rig.stereo;
  if (rig.pmd_lens.width == 0) {
    return;
  }
  const Eye pmd_eye(scene, rig.head * as_pose(rig.pmd_to_stereo));
  if (rig.pmd.pattern_rms_m > 0) {
    fixed_pattern_ =
        make_pattern(rig.pmd_lens, rig.modulation, rig.pmd, stream_seed(seed_, 0, kPattern));
  }
  pmd_ = render_pmd(scene, pmd_eye, rig.pmd_lens, rig.modulation, rig.pmd, fixed_pattern_);
  calibration_.pmd = sensor_constants(rig.pmd_lens, rig.modulation, rig.pmd);
  calibration_.pmd.fixed_pattern = fixed_pattern_;
  calibration_.pmd_to_stereo = rig.pmd_to_stereo;
}

Size RenderedScene::stereo_size() const noexcept { return {left_.width, left_.height}; }

Size RenderedScene::pmd_size() const noexcept { return {pmd_.mean.width, pmd_.mean.height / 4}; }

void RenderedScene::left(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept {
  expose_grey(left_.view(), grey_sigma_, stream_seed(seed_, number, kLeft), out);
}

void RenderedScene::right(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept {
  expose_grey(right_.view(), grey_sigma_, stream_seed(seed_, number, kRight), out);
}

void RenderedScene::pmd(std::uint32_t number, int index,
                        dsp::ImageView<std::uint16_t> out) noexcept {
  const std::uint32_t stream = kPmd + static_cast<std::uint32_t>(index);
  expose_pmd(pmd_, index, pmd_max_, stream_seed(seed_, number, stream), out);
}

}  // namespace stof::hal::emu
