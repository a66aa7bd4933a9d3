// Made by scripts/wire_table.py of firmware/wire/messages.json: change that.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/status.h"
#include "firmware/wire/messages/enums.h"
#include "firmware/wire/messages/structs.h"

namespace stof::wire {

inline constexpr std::size_t kFrameInfoBytes = 232;

// Type 2, one a frame.
struct FrameInfo {
  std::int64_t exposure_begin_ns = 0;  // begin of the stereo exposure, ns, same clock as the header
  std::int64_t exposure_end_ns = 0;    // end of it
  std::int64_t pmd_age_ns = 0;  // age of the PMD data, ns: exposure middle of the stereo pair less
                                // that of the PMD data; 0 without
  std::int64_t compute_ns = 0;  // what the frame took to compute, ns
  std::int64_t latency_ns = 0;  // from the exposure middle to the sending of this packet, ns
  std::array<std::uint32_t, 6>
      pixels_by_source{};   // pixels by source: none, stereo, PMD, both, resolved, conflict
  LoopCounters counters{};  // loop_counters
  std::array<std::uint32_t, 6> pixels_by_cause{};  // pixels by cause, as in "Causes"
  std::array<DriftReading, 5> drifts{};  // drift of the rig from its calibration, see "Drift"
  std::uint32_t drift_patches = 0;       // patches of the picture that the drifts are known from
  std::uint32_t drift_significant = 0;   // bit k: drift k is significant; calibrate the rig anew
  std::array<std::uint16_t, 8> tiles{};  // tiles of streams 1 to 8 in this frame; 0 = not sent
  std::uint8_t pmd_present = 0;          // 1: PMD data took part in this frame, 0: not
  std::uint8_t parity_groups =
      0;  // packets of parity that go with this frame, 255: so many or more; 0: none
  std::uint8_t cloud_step = 0;  // side of a cloud's block, px; 0: no cloud
  std::uint32_t settings_revision =
      0;  // of the settings this frame was made with: advances with every change
  std::array<std::uint32_t, 6>
      stage_us{};  // what each stage took, us: convert, match, fuse, watch; of the frame before:
                   // code, send (without the waits of pacing)
};

void encode_frame_info(const FrameInfo& value, std::span<std::byte, kFrameInfoBytes> out) noexcept;
// kCorrupt: shorter than kFrameInfoBytes. What follows is of a newer sender and ignored.
Result<FrameInfo> decode_frame_info(std::span<const std::byte> payload) noexcept;

}  // namespace stof::wire
