#include "firmware/wire/calibration/calibration_packet.h"

#include <cmath>
#include <concepts>
#include <limits>

namespace stof::wire {
namespace {

constexpr double kPixelScale = 65536;
constexpr double kRotationScale = 1 << 30;
constexpr double kNanometres = 1e9;

// False when the rounded value does not fit T (NaN does not).
template <std::integral T>
bool scale_to(double value, double scale, T& out) noexcept {
  const double scaled = std::round(value * scale);
  // 2^digits is exact in double and just above the largest T.
  const double bound = std::ldexp(1.0, std::numeric_limits<T>::digits);
  const double lowest = std::numeric_limits<T>::is_signed ? -bound : 0.0;
  if (!(scaled >= lowest) || !(scaled < bound)) {
    return false;
  }
  out = static_cast<T>(scaled);
  return true;
}

}  // namespace

Result<CalibrationPacket> make_calibration_packet(const dsp::Calibration& calibration,
                                                  dsp::QuarterMm max_range,
                                                  std::int64_t period_ns) noexcept {
  const dsp::Pinhole& left = calibration.stereo.left;
  const dsp::Pinhole& pmd = calibration.pmd.lens;
  CalibrationPacket packet;
  bool fits =
      scale_to(left.width, 1, packet.image_width) &&
      scale_to(left.height, 1, packet.image_height) && scale_to(pmd.width, 1, packet.pmd_width) &&
      scale_to(pmd.height, 1, packet.pmd_height) && scale_to(left.fx, kPixelScale, packet.fx) &&
      scale_to(left.fy, kPixelScale, packet.fy) && scale_to(left.cx, kPixelScale, packet.cx) &&
      scale_to(left.cy, kPixelScale, packet.cy) &&
      scale_to(calibration.stereo.doff_px, kPixelScale, packet.doff) &&
      scale_to(calibration.stereo.baseline_m, kNanometres, packet.baseline_nm);
  for (std::size_t i = 0; i < packet.rotation.size(); ++i) {
    fits =
        fits && scale_to(calibration.pmd_to_stereo.rotation[i], kRotationScale, packet.rotation[i]);
  }
  for (std::size_t i = 0; i < packet.translation_nm.size(); ++i) {
    fits = fits && scale_to(calibration.pmd_to_stereo.translation_m[i], kNanometres,
                            packet.translation_nm[i]);
  }
  if (!fits) {
    return fail(Status::kTooLarge);
  }
  packet.max_range = max_range;
  packet.modulation_hz = calibration.pmd.frequency.modulation.value;
  packet.period_ns = period_ns;
  return packet;
}

Result<CalibrationPacket> read_calibration_packet(std::span<const std::byte> payload) noexcept {
  const Result<CalibrationPacket> packet = decode_calibration_packet(payload);
  if (packet && (packet->fx <= 0 || packet->fy <= 0 || packet->depth_unit_um == 0)) {
    return fail(Status::kCorrupt);
  }
  return packet;
}

}  // namespace stof::wire
