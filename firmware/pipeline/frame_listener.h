#pragma once

#include <cstddef>
#include <span>

#include "dsp/fusion/depth_map.h"
#include "firmware/wire/messages/frame_info.h"
#include "firmware/wire/packet.h"

namespace stof::firmware {

// Gets every frame and message as well, on the loop's thread: the serial line.
class FrameListener {
 public:
  virtual ~FrameListener() = default;
  virtual void frame(const wire::FrameStamp& stamp, const wire::FrameInfo& info,
                     const dsp::DepthMap& map) noexcept = 0;
  // A sealed packet that is no part of a frame: health, events.
  virtual void packet(std::span<const std::byte> datagram) noexcept = 0;
};

}  // namespace stof::firmware
