#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/status.h"
#include "dsp/fusion/fuser.h"

namespace stof::wire {

inline constexpr std::size_t kSources = 6;  // values of dsp::Source
inline constexpr std::size_t kFrameInfoBytes = 120;

// Since the sender's start.
struct LoopCounters {
  std::uint64_t edges = 0;
  std::uint64_t frames_published = 0;
  std::uint64_t mispaired = 0;  // frames whose exposures did not belong to one edge
  std::uint64_t timeouts = 0;
  std::uint64_t deadline_misses = 0;
  std::uint64_t link_drops = 0;  // datagrams
};

// One a frame, its packet 0. Times in nanoseconds.
struct FrameInfo {
  std::int64_t exposure_begin_ns = 0;  // of the stereo pair, the packet's clock
  std::int64_t exposure_end_ns = 0;
  std::int64_t pmd_age_ns =
      0;  // middle of the stereo exposure less that of the PMD data; 0 without
  std::int64_t compute_ns = 0;  // what the frame took to compute
  std::int64_t latency_ns = 0;  // middle of the exposure to the sending of this packet
  std::array<std::uint32_t, kSources> pixels_by_source{};  // index: value of dsp::Source
  LoopCounters counters{};
  // Written by the Packetizer. 0 = the stream is not sent.
  std::uint16_t depth_packets = 0;
  std::uint16_t width_packets = 0;
  std::uint16_t source_packets = 0;
  bool pmd_present = false;

  std::uint32_t pixels(dsp::Source source) const noexcept {
    return pixels_by_source[static_cast<std::size_t>(source)];
  }
};

void encode_frame_info(const FrameInfo& info, std::span<std::byte, kFrameInfoBytes> out) noexcept;

// kCorrupt: shorter than kFrameInfoBytes. What follows them is of a newer sender and ignored.
Result<FrameInfo> decode_frame_info(std::span<const std::byte> payload) noexcept;

}  // namespace stof::wire
