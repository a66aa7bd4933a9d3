#include "hal/emu/imagery/sensors.h"

#include "hal/emu/imagery/grey.h"
#include "hal/emu/imagery/noise.h"
#include "hal/emu/imagery/soften.h"

namespace stof::hal::emu {
namespace {

// Every sensor, exposure and sample has its own stream of noise.
enum Stream : std::uint32_t { kLeft = 0, kRight = 1, kPmd = 2, kPattern = 6 };

std::uint64_t stream_seed(std::uint32_t rig_seed, std::uint32_t number,
                          std::uint32_t stream) noexcept {
  return dsp::mix(dsp::mix(rig_seed) + number) + stream;
}

}  // namespace

Sensors::Sensors(const Rig& rig)
    : rig_(rig),
      left_eye_(left_eye(rig)),
      right_eye_(right_eye(rig)),
      left_rays_(left_eye_.lens),
      right_rays_(right_eye_.lens),
      grey_sigma_(grey_noise(rig.grey)) {
  calibration_.stereo = rig.published ? rig.published->stereo : rig.stereo;
  if (rig.pmd_lens.width == 0) {
    return;
  }
  if (rig.pmd.pattern_rms_m > 0) {
    fixed_pattern_ =
        make_pattern(rig.pmd_lens, rig.modulation, rig.pmd, stream_seed(rig.seed, 0, kPattern));
  }
  pmd_rays_ = pmd_rays(rig.pmd_lens, rig.pmd.rays_per_side, rig.pmd.blur_px, ray_places(rig.pmd));
  pmd_centres_ = pmd_rays(rig.pmd_lens, 1);
  calibration_.pmd = sensor_constants(rig.pmd_lens, rig.modulation, rig.pmd);
  calibration_.pmd.fixed_pattern = fixed_pattern_;
  calibration_.pmd_to_stereo = rig.pmd_to_stereo;
  if (rig.published) {
    calibration_.pmd.lens = rig.published->pmd_lens;
    calibration_.pmd_to_stereo = rig.published->pmd_to_stereo;
  }
}

Size Sensors::stereo_size() const noexcept {
  return {rig_.stereo.left.width, rig_.stereo.left.height};
}

Size Sensors::pmd_size() const noexcept { return {rig_.pmd_lens.width, rig_.pmd_lens.height}; }

Viewpoint Sensors::left_viewpoint(const Scene& scene) const {
  return {scene, rig_.left_camera_pose * left_eye_.pose};
}

Viewpoint Sensors::right_viewpoint(const Scene& scene) const {
  return {scene, rig_.left_camera_pose * right_eye_.pose};
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

CleanViews Sensors::render_sharp(const Scene& scene) const {
  CleanViews views;
  views.left = render_grey(scene, left_viewpoint(scene), left_rays_, rig_.grey);
  views.right = render_grey(scene, right_viewpoint(scene), right_rays_, rig_.grey);
  if (pmd_size().width > 0) {
    views.pmd = render_samples(scene);
  }
  return views;
}

CleanViews Sensors::render(const Scene& scene) const {
  CleanViews views = render_sharp(scene);
  finish(views);
  return views;
}

void Sensors::render_pair(const Scene& scene, CleanViews& views) const {
  views.left = render_grey(scene, left_viewpoint(scene), left_rays_, rig_.grey);
  views.right = render_grey(scene, right_viewpoint(scene), right_rays_, rig_.grey);
  finish(views);
}

void Sensors::finish(CleanViews& views) const {
  soften(rig_.lenses, rig_.grey.black, views.left);
  soften(rig_.lenses, rig_.grey.black, views.right);
}

CleanSamples Sensors::render_samples(const Scene& scene) const {
  const Size size = pmd_size();
  CleanSamples samples{.mean = {size.width, 4 * size.height},
                       .sigma = {size.width, 4 * size.height}};
  render_pmd(scene, pmd_viewpoint(scene), pmd_camera(), whole_picture(rig_.pmd_lens), samples);
  return samples;
}

Parts Sensors::render_over(const Scene& scene, int first, CleanViews& views) const {
  Parts parts = render_pair_over(scene, first, views);
  if (pmd_size().width > 0) {
    parts.pmd = render_samples_over(scene, first, views.pmd);
  }
  return parts;
}

Parts Sensors::render_pair_over(const Scene& scene, int first, CleanViews& views) const {
  const auto runs = [&](const Viewpoint& viewpoint, const LensRays& rays) {
    return rays.centres().empty() ? runs_of_objects(viewpoint, rays.lens(), first)
                                  : runs_of_objects(viewpoint, rays.lens(), rays.centres(), first);
  };
  const Viewpoint left = left_viewpoint(scene);
  const Viewpoint right = right_viewpoint(scene);
  Parts parts{.left = runs(left, left_rays_), .right = runs(right, right_rays_), .pmd = {}};
  render_grey_over(scene, left, left_rays_, rig_.grey, parts.left, first, views.left);
  render_grey_over(scene, right, right_rays_, rig_.grey, parts.right, first, views.right);
  return parts;
}

std::vector<Run> Sensors::render_samples_over(const Scene& scene, int first,
                                              CleanSamples& samples) const {
  const Viewpoint viewpoint = pmd_viewpoint(scene);
  std::vector<Run> runs =
      runs_of_objects(viewpoint, rig_.pmd_lens, pmd_centres_, first, reach_of(rig_.pmd.blur_px));
  render_pmd(scene, viewpoint, pmd_camera(), runs, samples);
  return runs;
}

std::vector<Run> Sensors::widened(const std::vector<Run>& runs) const {
  const int reach = reach_of(rig_.lenses.blur_px);
  return reach == 0 ? runs : grown(runs, rig_.stereo.left.width, reach);
}

dataset::Image<float> Sensors::depth(const Scene& scene) const {
  if (rig_.stereo.converging) {  // of the pixels as they are, along the axes of the rig
    const Vec3 along = left_eye_.pose.turn_back({0, 0, 1});
    return render_depth(left_viewpoint(scene), left_rays_, along);
  }
  return render_depth({scene, rig_.left_camera_pose}, LensRays(rig_.stereo.left));
}

dataset::Image<std::uint8_t> Sensors::visible(const Scene& scene) const {
  if (!rig_.stereo.raw) {
    return render_visible(left_viewpoint(scene), left_rays_, right_viewpoint(scene),
                          right_eye_.lens);
  }
  Rig rectified = rig_;  // the pair that the pictures become
  rectified.stereo.raw.reset();
  const Eye other = right_eye(rectified);
  return render_visible({scene, rig_.left_camera_pose}, LensRays(rig_.stereo.left),
                        {scene, rig_.left_camera_pose * other.pose}, other.lens);
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
