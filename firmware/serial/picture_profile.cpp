#include "firmware/serial/picture_profile.h"

#include <algorithm>
#include <cstdlib>

#include "dsp/fusion/decimate.h"

namespace stof::firmware {

int profile_step(const PictureProfile& profile, int width, int height) noexcept {
  return std::max({dsp::kLeastBlock, dsp::decimated(width, profile.width),
                   dsp::decimated(height, profile.height)});
}

void coarsen(int unit, dsp::ImageView<dsp::QuarterMm> depth,
             dsp::ImageView<dsp::QuarterMm> width) noexcept {
  for (int y = 0; y < depth.height(); ++y) {
    for (int x = 0; x < depth.width(); ++x) {
      dsp::QuarterMm& middle = depth.at(x, y);
      dsp::QuarterMm& control = width.at(x, y);
      if (middle == dsp::kNoDepth) {
        continue;
      }
      const int units = std::max(middle / unit, 1);
      const int moved = std::abs(middle - units * unit);
      const int widths = (control + 2 * moved + unit - 1) / unit;
      middle = static_cast<dsp::QuarterMm>(units);
      control = static_cast<dsp::QuarterMm>(std::min<int>(widths, dsp::kMaxQuarterMm));
    }
  }
}

wire::CalibrationPacket profile_calibration(const wire::CalibrationPacket& calibration,
                                            const PictureProfile& profile) noexcept {
  const int step = profile_step(profile, calibration.image_width, calibration.image_height);
  const std::uint32_t unit = static_cast<std::uint32_t>(profile.unit);
  // u' = (u - (step - 1) / 2) / step
  const std::int32_t middle = (step - 1) * (std::int32_t{1} << 15);
  wire::CalibrationPacket out = calibration;
  out.image_width = static_cast<std::uint16_t>(dsp::decimated(calibration.image_width, step));
  out.image_height = static_cast<std::uint16_t>(dsp::decimated(calibration.image_height, step));
  out.fx = calibration.fx / step;
  out.fy = calibration.fy / step;
  out.cx = (calibration.cx - middle) / step;
  out.cy = (calibration.cy - middle) / step;
  out.doff = calibration.doff / step;
  out.depth_unit_um = calibration.depth_unit_um * unit;
  out.max_range = calibration.max_range / unit;
  return out;
}

}  // namespace stof::firmware
