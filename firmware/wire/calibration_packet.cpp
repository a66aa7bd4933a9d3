#include "firmware/wire/calibration_packet.h"

#include <cmath>
#include <concepts>
#include <limits>

#include "firmware/wire/bytes.h"

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
  packet.modulation_hz = calibration.pmd.tone.modulation.value;
  packet.period_ns = period_ns;
  return packet;
}

// docs/WIRE.md, "Calibration".
void encode_calibration_packet(const CalibrationPacket& packet,
                               std::span<std::byte, kCalibrationPacketBytes> out) noexcept {
  put_u16(out.subspan<0, 2>(), packet.image_width);
  put_u16(out.subspan<2, 2>(), packet.image_height);
  put_u16(out.subspan<4, 2>(), packet.pmd_width);
  put_u16(out.subspan<6, 2>(), packet.pmd_height);
  put_i32(out.subspan<8, 4>(), packet.fx);
  put_i32(out.subspan<12, 4>(), packet.fy);
  put_i32(out.subspan<16, 4>(), packet.cx);
  put_i32(out.subspan<20, 4>(), packet.cy);
  put_i32(out.subspan<24, 4>(), packet.doff);
  put_u32(out.subspan<28, 4>(), packet.depth_unit_um);
  put_u32(out.subspan<32, 4>(), packet.max_range);
  put_u32(out.subspan<36, 4>(), packet.modulation_hz);
  put_i64(out.subspan<40, 8>(), packet.baseline_nm);
  put_i64(out.subspan<48, 8>(), packet.period_ns);
  for (std::size_t i = 0; i < packet.rotation.size(); ++i) {
    put_i32(out.subspan(56 + 4 * i).first<4>(), packet.rotation[i]);
  }
  put_u32(out.subspan<92, 4>(), 0);
  for (std::size_t i = 0; i < packet.translation_nm.size(); ++i) {
    put_i64(out.subspan(96 + 8 * i).first<8>(), packet.translation_nm[i]);
  }
}

Result<CalibrationPacket> decode_calibration_packet(std::span<const std::byte> payload) noexcept {
  if (payload.size() < kCalibrationPacketBytes) {
    return fail(Status::kCorrupt);
  }
  const std::span<const std::byte, kCalibrationPacketBytes> in =
      payload.first<kCalibrationPacketBytes>();
  CalibrationPacket packet{
      .image_width = get_u16(in.subspan<0, 2>()),
      .image_height = get_u16(in.subspan<2, 2>()),
      .pmd_width = get_u16(in.subspan<4, 2>()),
      .pmd_height = get_u16(in.subspan<6, 2>()),
      .fx = get_i32(in.subspan<8, 4>()),
      .fy = get_i32(in.subspan<12, 4>()),
      .cx = get_i32(in.subspan<16, 4>()),
      .cy = get_i32(in.subspan<20, 4>()),
      .doff = get_i32(in.subspan<24, 4>()),
      .depth_unit_um = get_u32(in.subspan<28, 4>()),
      .max_range = get_u32(in.subspan<32, 4>()),
      .modulation_hz = get_u32(in.subspan<36, 4>()),
      .baseline_nm = get_i64(in.subspan<40, 8>()),
      .period_ns = get_i64(in.subspan<48, 8>()),
  };
  for (std::size_t i = 0; i < packet.rotation.size(); ++i) {
    packet.rotation[i] = get_i32(in.subspan(56 + 4 * i).first<4>());
  }
  for (std::size_t i = 0; i < packet.translation_nm.size(); ++i) {
    packet.translation_nm[i] = get_i64(in.subspan(96 + 8 * i).first<8>());
  }
  if (packet.fx <= 0 || packet.fy <= 0 || packet.depth_unit_um == 0) {
    return fail(Status::kCorrupt);
  }
  return packet;
}

}  // namespace stof::wire
