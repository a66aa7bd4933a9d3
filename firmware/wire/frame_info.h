#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "dsp/base/status.h"
#include "dsp/fusion/fuser.h"

namespace stof::wire {

inline constexpr std::size_t kSources = 6;  // values of dsp::Source
inline constexpr std::size_t kCauses = 6;   // values of dsp::Cause
inline constexpr std::size_t kDrifts = 5;   // values of dsp::DriftParameter
inline constexpr std::size_t kFrameInfoBytes = 192;
inline constexpr std::size_t kShortFrameInfoBytes = 120;  // of senders without causes and drift

// Since the sender's start.
struct LoopCounters {
  std::uint64_t edges = 0;
  std::uint64_t frames_published = 0;
  std::uint64_t mispaired = 0;  // frames whose exposures did not belong to one edge
  std::uint64_t timeouts = 0;
  std::uint64_t deadline_misses = 0;
  std::uint64_t link_drops = 0;  // datagrams
};

// One drift of the rig from its calibration, as dsp::Drift: turns in micro-radians, the range
// offset in 1/16 mm, the disparity offset in 1/1000 px.
struct DriftReading {
  std::int32_t value = 0;
  std::int32_t sigma = std::numeric_limits<std::int32_t>::max();  // of an unknown one
  bool significant = false;
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
  std::array<std::uint32_t, kCauses> pixels_by_cause{};  // index: value of dsp::Cause
  std::array<DriftReading, kDrifts> drifts{};            // index: value of dsp::DriftParameter
  std::uint32_t drift_patches = 0;                       // that the drifts are known from

  std::uint32_t pixels(dsp::Source source) const noexcept {
    return pixels_by_source[static_cast<std::size_t>(source)];
  }
};

void encode_frame_info(const FrameInfo& info, std::span<std::byte, kFrameInfoBytes> out) noexcept;

// kCorrupt: shorter than kShortFrameInfoBytes. Shorter than kFrameInfoBytes: no causes, no drifts.
// What follows them is of a newer sender and ignored.
Result<FrameInfo> decode_frame_info(std::span<const std::byte> payload) noexcept;

}  // namespace stof::wire
