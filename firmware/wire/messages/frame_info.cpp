// Made by scripts/wire_table.py of firmware/wire/messages.json: change that.
#include "firmware/wire/messages/frame_info.h"

#include <algorithm>

#include "firmware/wire/bytes.h"

namespace stof::wire {

void encode_frame_info(const FrameInfo& value, std::span<std::byte, kFrameInfoBytes> out) noexcept {
  put_i64(out.subspan<0, 8>(), value.exposure_begin_ns);
  put_i64(out.subspan<8, 8>(), value.exposure_end_ns);
  put_i64(out.subspan<16, 8>(), value.pmd_age_ns);
  put_i64(out.subspan<24, 8>(), value.compute_ns);
  put_i64(out.subspan<32, 8>(), value.latency_ns);
  for (std::size_t i = 0; i < 6; ++i) {
    put_u32(out.subspan(40 + 4 * i).first<4>(), value.pixels_by_source[i]);
  }
  put_loop_counters(out.subspan<64, 48>(), value.counters);
  for (std::size_t i = 0; i < 6; ++i) {
    put_u32(out.subspan(112 + 4 * i).first<4>(), value.pixels_by_cause[i]);
  }
  for (std::size_t i = 0; i < 5; ++i) {
    put_drift_reading(out.subspan(136 + 8 * i).first<8>(), value.drifts[i]);
  }
  put_u32(out.subspan<176, 4>(), value.drift_patches);
  put_u32(out.subspan<180, 4>(), value.drift_significant);
  for (std::size_t i = 0; i < 8; ++i) {
    put_u16(out.subspan(184 + 2 * i).first<2>(), value.tiles[i]);
  }
  put_u8(out.subspan<200, 1>(), value.pmd_present);
  put_u8(out.subspan<201, 1>(), value.parity_groups);
  put_u8(out.subspan<202, 1>(), value.cloud_step);
  std::ranges::fill(out.subspan<203, 1>(), std::byte{0});
  put_u32(out.subspan<204, 4>(), value.settings_revision);
  for (std::size_t i = 0; i < 6; ++i) {
    put_u32(out.subspan(208 + 4 * i).first<4>(), value.stage_us[i]);
  }
}

Result<FrameInfo> decode_frame_info(std::span<const std::byte> payload) noexcept {
  if (payload.size() < kFrameInfoBytes) {
    return fail(Status::kCorrupt);
  }
  const std::span<const std::byte, kFrameInfoBytes> in = payload.first<kFrameInfoBytes>();
  FrameInfo value;
  value.exposure_begin_ns = get_i64(in.subspan<0, 8>());
  value.exposure_end_ns = get_i64(in.subspan<8, 8>());
  value.pmd_age_ns = get_i64(in.subspan<16, 8>());
  value.compute_ns = get_i64(in.subspan<24, 8>());
  value.latency_ns = get_i64(in.subspan<32, 8>());
  for (std::size_t i = 0; i < 6; ++i) {
    value.pixels_by_source[i] = get_u32(in.subspan(40 + 4 * i).first<4>());
  }
  value.counters = get_loop_counters(in.subspan<64, 48>());
  for (std::size_t i = 0; i < 6; ++i) {
    value.pixels_by_cause[i] = get_u32(in.subspan(112 + 4 * i).first<4>());
  }
  for (std::size_t i = 0; i < 5; ++i) {
    value.drifts[i] = get_drift_reading(in.subspan(136 + 8 * i).first<8>());
  }
  value.drift_patches = get_u32(in.subspan<176, 4>());
  value.drift_significant = get_u32(in.subspan<180, 4>());
  for (std::size_t i = 0; i < 8; ++i) {
    value.tiles[i] = get_u16(in.subspan(184 + 2 * i).first<2>());
  }
  value.pmd_present = get_u8(in.subspan<200, 1>());
  value.parity_groups = get_u8(in.subspan<201, 1>());
  value.cloud_step = get_u8(in.subspan<202, 1>());
  value.settings_revision = get_u32(in.subspan<204, 4>());
  for (std::size_t i = 0; i < 6; ++i) {
    value.stage_us[i] = get_u32(in.subspan(208 + 4 * i).first<4>());
  }
  return value;
}

}  // namespace stof::wire
