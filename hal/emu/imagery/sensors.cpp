#include "hal/emu/imagery/sensors.h"

#include "hal/emu/imagery/grey.h"
#include "hal/emu/imagery/noise.h"

namespace stof::hal::emu {
namespace {

// Every sensor, exposure and sample has its own stream of noise.
enum Stream : std::uint32_t { kLeft = 0, kRight = 1, kPmd = 2, kPattern = 6 };

std::uint64_t stream_seed(std::uint32_t rig_seed, std::uint32_t number,
                          std::uint32_t stream) noexcept {
  return dsp::mix(dsp::mix(rig_seed) + number) + stream;
}

dsp::Pinhole right_lens(const dsp::StereoRig& rig) noexcept {
  dsp::Pinhole lens = rig.left;
  lens.cx += rig.doff_px;
  return lens;
}

}  // namespace

Sensors::Sensors(const Rig& rig)
    : rig_(rig), right_lens_(right_lens(rig.stereo)), grey_sigma_(grey_noise(rig.grey)) {
  calibration_.stereo = rig.stereo;
  if (rig.pmd_lens.width == 0) {
    return;
  }
  if (rig.pmd.pattern_rms_m > 0) {
    fixed_pattern_ =
        make_pattern(rig.pmd_lens, rig.modulation, rig.pmd, stream_seed(rig.seed, 0, kPattern));
  }
  pmd_rays_ = pmd_rays(rig.pmd_lens, rig.pmd.rays_per_side);
  pmd_centres_ = pmd_rays(rig.pmd_lens, 1);
  calibration_.pmd = sensor_constants(rig.pmd_lens, rig.modulation, rig.pmd);
  calibration_.pmd.fixed_pattern = fixed_pattern_;
  calibration_.pmd_to_stereo = rig.pmd_to_stereo;
}

Size Sensors::stereo_size() const noexcept {
  return {rig_.stereo.left.width, rig_.stereo.left.height};
}

Size Sensors::pmd_size() const noexcept { return {rig_.pmd_lens.width, rig_.pmd_lens.height}; }

Viewpoint Sensors::left_viewpoint(const Scene& scene) const {
  return {scene, rig_.left_camera_pose};
}

Viewpoint Sensors::right_viewpoint(const Scene& scene) const {
  return {scene, rig_.left_camera_pose * Pose{.position = {rig_.stereo.baseline_m, 0, 0}}};
}

Viewpoint Sensors::pmd_viewpoint(const Scene& scene) const {
  return {scene, rig_.left_camera_pose * true_pmd_pose(rig_)};
}

PmdCameraModel Sensors::pmd_camera() const noexcept {
  return {.lens = rig_.pmd_lens,
          .modulation = rig_.modulation,
          .model = rig_.pmd,
          .rays = pmd_rays_,
          .pattern = fixed_pattern_,
          .offset_m = rig_.misplacement.range_offset_m};
}

CleanViews Sensors::render(const Scene& scene) const {
  CleanViews views;
  render_pair(scene, views);
  if (pmd_size().width > 0) {
    views.pmd = render_samples(scene);
  }
  return views;
}

void Sensors::render_pair(const Scene& scene, CleanViews& views) const {
  views.left = render_grey(scene, left_viewpoint(scene), rig_.stereo.left, rig_.grey);
  views.right = render_grey(scene, right_viewpoint(scene), right_lens_, rig_.grey);
}

CleanSamples Sensors::render_samples(const Scene& scene) const {
  const Size size = pmd_size();
  CleanSamples samples{.mean = {size.width, 4 * size.height},
                       .sigma = {size.width, 4 * size.height}};
  render_pmd(scene, pmd_viewpoint(scene), pmd_camera(), whole_picture(rig_.pmd_lens), samples);
  return samples;
}

Parts Sensors::render_over(const Scene& scene, int first, CleanViews& views) const {
  const dsp::Pinhole& lens = rig_.stereo.left;
  const Viewpoint left = left_viewpoint(scene);
  const Viewpoint right = right_viewpoint(scene);
  Parts parts{.left = runs_of_objects(left, lens, first),
              .right = runs_of_objects(right, right_lens_, first),
              .pmd = {}};
  render_grey_over(scene, left, lens, rig_.grey, parts.left, first, views.left);
  render_grey_over(scene, right, right_lens_, rig_.grey, parts.right, first, views.right);
  if (pmd_size().width > 0) {
    const Viewpoint viewpoint = pmd_viewpoint(scene);
    parts.pmd = runs_of_objects(viewpoint, rig_.pmd_lens, pmd_centres_, first);
    render_pmd(scene, viewpoint, pmd_camera(), parts.pmd, views.pmd);
  }
  return parts;
}

dataset::Image<float> Sensors::depth(const Scene& scene) const {
  return render_depth(left_viewpoint(scene), rig_.stereo.left);
}

dataset::Image<std::uint8_t> Sensors::visible(const Scene& scene) const {
  return render_visible(left_viewpoint(scene), rig_.stereo.left, right_viewpoint(scene),
                        right_lens_);
}

void Sensors::left(const CleanViews& views, std::uint32_t number,
                   dsp::ImageView<std::uint8_t> out) const noexcept {
  expose_grey(views.left.view(), grey_sigma_, stream_seed(rig_.seed, number, kLeft), out);
}

void Sensors::right(const CleanViews& views, std::uint32_t number,
                    dsp::ImageView<std::uint8_t> out) const noexcept {
  expose_grey(views.right.view(), grey_sigma_, stream_seed(rig_.seed, number, kRight), out);
}

void Sensors::pmd(const CleanViews& views, std::uint32_t number, int index,
                  dsp::ImageView<std::uint16_t> out) const noexcept {
  const std::uint32_t stream = kPmd + static_cast<std::uint32_t>(index);
  expose_pmd(views.pmd, index, (1 << rig_.pmd.bits) - 1, stream_seed(rig_.seed, number, stream),
             out);
}

}  // namespace stof::hal::emu
