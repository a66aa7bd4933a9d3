#include "firmware/wire/frame_info.h"

#include "firmware/wire/bytes.h"

namespace stof::wire {

// docs/WIRE.md, "Frame info".
void encode_frame_info(const FrameInfo& info, std::span<std::byte, kFrameInfoBytes> out) noexcept {
  put_i64(out.subspan<0, 8>(), info.exposure_begin_ns);
  put_i64(out.subspan<8, 8>(), info.exposure_end_ns);
  put_i64(out.subspan<16, 8>(), info.pmd_age_ns);
  put_i64(out.subspan<24, 8>(), info.compute_ns);
  put_i64(out.subspan<32, 8>(), info.latency_ns);
  for (std::size_t i = 0; i < kSources; ++i) {
    put_u32(out.subspan(40 + 4 * i).first<4>(), info.pixels_by_source[i]);
  }
  put_u64(out.subspan<64, 8>(), info.counters.edges);
  put_u64(out.subspan<72, 8>(), info.counters.frames_published);
  put_u64(out.subspan<80, 8>(), info.counters.mispaired);
  put_u64(out.subspan<88, 8>(), info.counters.timeouts);
  put_u64(out.subspan<96, 8>(), info.counters.deadline_misses);
  put_u64(out.subspan<104, 8>(), info.counters.link_drops);
  put_u16(out.subspan<112, 2>(), info.depth_packets);
  put_u16(out.subspan<114, 2>(), info.width_packets);
  put_u16(out.subspan<116, 2>(), info.source_packets);
  put_u8(out.subspan<118, 1>(), info.pmd_present ? 1 : 0);
  put_u8(out.subspan<119, 1>(), 0);
  for (std::size_t i = 0; i < kCauses; ++i) {
    put_u32(out.subspan(120 + 4 * i).first<4>(), info.pixels_by_cause[i]);
  }
  unsigned significant = 0;
  for (std::size_t i = 0; i < kDrifts; ++i) {
    const DriftReading& drift = info.drifts[i];
    put_i32(out.subspan(144 + 8 * i).first<4>(), drift.value);
    put_i32(out.subspan(148 + 8 * i).first<4>(), drift.sigma);
    significant |= drift.significant ? 1U << i : 0U;
  }
  put_u32(out.subspan<184, 4>(), info.drift_patches);
  put_u32(out.subspan<188, 4>(), significant);
}

namespace {

void decode_health(std::span<const std::byte, kFrameInfoBytes> in, FrameInfo& info) noexcept {
  for (std::size_t i = 0; i < kCauses; ++i) {
    info.pixels_by_cause[i] = get_u32(in.subspan(120 + 4 * i).first<4>());
  }
  const std::uint32_t significant = get_u32(in.subspan<188, 4>());
  for (std::size_t i = 0; i < kDrifts; ++i) {
    info.drifts[i] = {.value = get_i32(in.subspan(144 + 8 * i).first<4>()),
                      .sigma = get_i32(in.subspan(148 + 8 * i).first<4>()),
                      .significant = ((significant >> i) & 1U) != 0};
  }
  info.drift_patches = get_u32(in.subspan<184, 4>());
}

}  // namespace

Result<FrameInfo> decode_frame_info(std::span<const std::byte> payload) noexcept {
  if (payload.size() < kShortFrameInfoBytes) {
    return fail(Status::kCorrupt);
  }
  const std::span<const std::byte, kShortFrameInfoBytes> in = payload.first<kShortFrameInfoBytes>();
  FrameInfo info{
      .exposure_begin_ns = get_i64(in.subspan<0, 8>()),
      .exposure_end_ns = get_i64(in.subspan<8, 8>()),
      .pmd_age_ns = get_i64(in.subspan<16, 8>()),
      .compute_ns = get_i64(in.subspan<24, 8>()),
      .latency_ns = get_i64(in.subspan<32, 8>()),
      .counters = {.edges = get_u64(in.subspan<64, 8>()),
                   .frames_published = get_u64(in.subspan<72, 8>()),
                   .mispaired = get_u64(in.subspan<80, 8>()),
                   .timeouts = get_u64(in.subspan<88, 8>()),
                   .deadline_misses = get_u64(in.subspan<96, 8>()),
                   .link_drops = get_u64(in.subspan<104, 8>())},
      .depth_packets = get_u16(in.subspan<112, 2>()),
      .width_packets = get_u16(in.subspan<114, 2>()),
      .source_packets = get_u16(in.subspan<116, 2>()),
      .pmd_present = get_u8(in.subspan<118, 1>()) != 0,
  };
  for (std::size_t i = 0; i < kSources; ++i) {
    info.pixels_by_source[i] = get_u32(in.subspan(40 + 4 * i).first<4>());
  }
  if (payload.size() >= kFrameInfoBytes) {
    decode_health(payload.first<kFrameInfoBytes>(), info);
  }
  return info;
}

}  // namespace stof::wire
