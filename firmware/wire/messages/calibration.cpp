// Made by scripts/wire_table.py of firmware/wire/messages.json: change that.
#include "firmware/wire/messages/calibration.h"

#include <algorithm>

#include "firmware/wire/bytes.h"

namespace stof::wire {

void encode_calibration_packet(const CalibrationPacket& value,
                               std::span<std::byte, kCalibrationPacketBytes> out) noexcept {
  put_u16(out.subspan<0, 2>(), value.image_width);
  put_u16(out.subspan<2, 2>(), value.image_height);
  put_u16(out.subspan<4, 2>(), value.pmd_width);
  put_u16(out.subspan<6, 2>(), value.pmd_height);
  put_i32(out.subspan<8, 4>(), value.fx);
  put_i32(out.subspan<12, 4>(), value.fy);
  put_i32(out.subspan<16, 4>(), value.cx);
  put_i32(out.subspan<20, 4>(), value.cy);
  put_i32(out.subspan<24, 4>(), value.doff);
  put_u32(out.subspan<28, 4>(), value.depth_unit_um);
  put_u32(out.subspan<32, 4>(), value.max_range);
  put_u32(out.subspan<36, 4>(), value.modulation_hz);
  put_i64(out.subspan<40, 8>(), value.baseline_nm);
  put_i64(out.subspan<48, 8>(), value.period_ns);
  for (std::size_t i = 0; i < 9; ++i) {
    put_i32(out.subspan(56 + 4 * i).first<4>(), value.rotation[i]);
  }
  std::ranges::fill(out.subspan<92, 4>(), std::byte{0});
  for (std::size_t i = 0; i < 3; ++i) {
    put_i64(out.subspan(96 + 8 * i).first<8>(), value.translation_nm[i]);
  }
}

Result<CalibrationPacket> decode_calibration_packet(std::span<const std::byte> payload) noexcept {
  if (payload.size() < kCalibrationPacketBytes) {
    return fail(Status::kCorrupt);
  }
  const std::span<const std::byte, kCalibrationPacketBytes> in =
      payload.first<kCalibrationPacketBytes>();
  CalibrationPacket value;
  value.image_width = get_u16(in.subspan<0, 2>());
  value.image_height = get_u16(in.subspan<2, 2>());
  value.pmd_width = get_u16(in.subspan<4, 2>());
  value.pmd_height = get_u16(in.subspan<6, 2>());
  value.fx = get_i32(in.subspan<8, 4>());
  value.fy = get_i32(in.subspan<12, 4>());
  value.cx = get_i32(in.subspan<16, 4>());
  value.cy = get_i32(in.subspan<20, 4>());
  value.doff = get_i32(in.subspan<24, 4>());
  value.depth_unit_um = get_u32(in.subspan<28, 4>());
  value.max_range = get_u32(in.subspan<32, 4>());
  value.modulation_hz = get_u32(in.subspan<36, 4>());
  value.baseline_nm = get_i64(in.subspan<40, 8>());
  value.period_ns = get_i64(in.subspan<48, 8>());
  for (std::size_t i = 0; i < 9; ++i) {
    value.rotation[i] = get_i32(in.subspan(56 + 4 * i).first<4>());
  }
  for (std::size_t i = 0; i < 3; ++i) {
    value.translation_nm[i] = get_i64(in.subspan(96 + 8 * i).first<8>());
  }
  return value;
}

}  // namespace stof::wire
