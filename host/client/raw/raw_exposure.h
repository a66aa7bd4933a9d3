#pragma once

#include <array>
#include <cstdint>

#include "dsp/base/image.h"
#include "firmware/wire/frame/raw_packets.h"
#include "firmware/wire/messages/raw_info.h"
#include "firmware/wire/packet.h"
#include "host/client/frame/frame.h"

namespace stof::client {

// What the cameras gave for one exposure, bit for bit. stamp.freshness is its id: the frame with
// the same freshness was computed from it. A picture is here as a whole or not at all.
// Views: valid until the next call that may return one.
struct RawExposure {
  wire::Origin origin{};
  wire::FrameStamp stamp{};
  wire::RawInfo info{};
  // The part and the columns and rows that info tells; empty: not sent, or missing.
  dsp::ImageView<const std::uint8_t> left{};
  dsp::ImageView<const std::uint8_t> right{};
  std::array<dsp::ImageView<const std::uint16_t>, wire::kRawSamples> pmd{};  // A0 to A3
  // Of info.pictures, those of which a packet did not arrive.
  std::uint8_t missing = 0;
  Time last_packet{};  // arrived then

  bool complete() const noexcept { return missing == 0; }
};

// Every exposure whose pictures the sensor began to send is counted in exactly one of the first
// four; what it did not send, or not to its end, in the fifth as well, as the sensor tells it.
struct RawStatistics {
  std::uint64_t complete = 0;    // delivered with all pictures
  std::uint64_t incomplete = 0;  // delivered without those that missed a packet
  std::uint64_t lost = 0;        // nothing of it arrived in time, or not its raw info
  std::uint64_t untaken = 0;     // nobody took them, or the sender started again before
  std::uint64_t dropped = 0;     // by the sensor: no time or no link for them
};

}  // namespace stof::client
