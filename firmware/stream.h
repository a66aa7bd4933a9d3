#pragma once

#include <cstdint>
#include <optional>

#include "firmware/events.h"
#include "firmware/pipeline.h"
#include "firmware/shot.h"
#include "firmware/wire/packetizer.h"
#include "hal/clock.h"
#include "hal/link.h"

namespace stof::firmware {

// A link that spreads the datagrams of a frame evenly over a time, in small bursts: a receiver's
// socket holds a fraction of a frame only. Passed moments are not waited for.
class PacedLink final : public wire::PacketSink {
 public:
  static constexpr std::uint32_t kBurst = 8;

  PacedLink(hal::Clock& clock, hal::Link& link) noexcept : clock_(clock), link_(link) {}

  // The next `packets` datagrams go out between now and `latest`; those after them at once.
  void begin(std::uint32_t packets, hal::Time latest) noexcept;
  Status send(std::span<const std::byte> datagram) noexcept override;

 private:
  hal::Clock& clock_;
  hal::Link& link_;
  hal::Time start_;
  hal::Duration budget_{};
  std::uint32_t packets_ = 0;
  std::uint32_t sent_ = 0;
};

// Who sends, and what every receiver has to know about it.
struct StreamSetup {
  wire::Origin origin;
  wire::ClockState clock = wire::ClockState::kMonotonic;
  wire::CalibrationPacket calibration;  // goes out with the first frame, then once a second
};

// Depth maps to datagrams.
class Stream {
 public:
  Stream(const StreamSetup& setup, hal::Clock& clock, hal::Link& link, Events& events) noexcept
      : setup_(setup),
        clock_(clock),
        events_(events),
        paced_(clock, link),
        packetizer_(setup.origin, paced_) {}

  // Sends one frame, paced so that it ends at `latest`, or at once when that has passed. Counts
  // packets. Never blocks longer than until `latest`. The first status of the link that was not
  // kOk: kWouldBlock, kDeviceError (some were dropped), kDeviceLost (reopen).
  Status publish(const Shot& shot, const Output& output, hal::Time latest) noexcept;

 private:
  wire::FrameInfo describe(const Shot& shot, const Output& output) const noexcept;

  StreamSetup setup_;
  hal::Clock& clock_;
  Events& events_;
  PacedLink paced_;
  wire::Packetizer packetizer_;
  std::uint32_t number_ = 0;
  std::optional<hal::Time> calibration_due_;
};

}  // namespace stof::firmware
