#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "host/client/frame/frame.h"
#include "host/client/session/stream_verifier.h"

namespace stof::client {

struct ReassemblerOptions {
  // Only this device is listened to; without it, the first one heard.
  std::optional<std::uint32_t> device_id{};
  // Largest image of a stream accepted: bounds what datagrams can make us allocate (27 bytes a
  // pixel with all eight streams, four frames; and 5 MB a frame with parity).
  std::size_t max_pixels = std::size_t{1} << 21;
  // A frame that got no packet for so long is closed. Without it 1.5 periods of the sensor, but at
  // least 100 ms, so that a computer busy for a moment does not look like a lost packet. It decides
  // only where the stream has stopped: otherwise a later frame closes an earlier one.
  std::optional<Duration> frame_timeout{};
  // What arrived longer ago is not delivered: packets of frames that waited for so long to be read,
  // and frames whose last packet did; nor what was on its way for so much longer than others
  // (FrameDelay). Not given: one period of the sensor and 100 ms, or 50 ms more than a frame is
  // waited for, if that is longer; 200 ms as long as the period is not known.
  std::optional<Duration> max_age{};
  // Packets of a serial line, on which the unit of depth changes with the picture.
  bool serial_line = false;
  bool raw_pictures = false;  // were asked for; else they are unknown
  // Where there is one, only what it finds signed is looked at. It outlives the reassembler.
  StreamVerifier* verifier = nullptr;
};

}  // namespace stof::client
