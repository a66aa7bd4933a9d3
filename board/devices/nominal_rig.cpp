#include "board/devices/nominal_rig.h"

namespace stof::board {
namespace {

dsp::Pinhole lens(PictureSize size, double focal_px, int largest_width) noexcept {
  const double focal = focal_px * size.width / largest_width;
  return {.width = size.width,
          .height = size.height,
          .fx = focal,
          .fy = focal,
          .cx = (size.width - 1) / 2.0,
          .cy = (size.height - 1) / 2.0};
}

}  // namespace

dsp::Calibration nominal_rig(const Config& config, PictureSize stereo, PictureSize pmd) noexcept {
  dsp::Calibration rig;
  rig.stereo = {.left = lens(stereo, config.nominal.stereo_focal_px, config.stereo.width),
                .baseline_m = config.nominal.baseline_m};
  if (pmd.width > 0) {
    rig.pmd.lens = lens(pmd, config.nominal.pmd_focal_px, config.pmd.width);
    rig.pmd.frequency.modulation = dsp::Hertz{config.devices.pmd.modulation_khz * 1000};
    rig.pmd_to_stereo.translation_m = {config.nominal.pmd_right_m, config.nominal.pmd_below_m, 0};
  }
  return rig;
}

}  // namespace stof::board
