#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "firmware/wire/messages/calibration.h"
#include "firmware/wire/messages/event.h"
#include "firmware/wire/messages/health.h"
#include "firmware/wire/packet.h"

namespace stof::client {

// The outcome of a packet outside the frames.
enum class MessageOutcome : std::uint8_t {
  kTaken,  // also the repetition of an event, which is not delivered again
  kDuplicate,
  kLate,  // a newer one arrived before
  kContradicting,
};

// The messages of one session beside its frames.
class SessionMessages {
 public:
  // A session begins. Returns the events that nobody took.
  std::size_t restart();

  MessageOutcome push_calibration(const wire::PacketView& packet);
  MessageOutcome push_health(const wire::PacketView& packet);
  // overflow: an older event was given up for it.
  MessageOutcome push_event(const wire::PacketView& packet, bool& overflow);

  const std::optional<wire::CalibrationPacket>& calibration() const noexcept {
    return calibration_;
  }
  const std::optional<wire::HealthReport>& health() const noexcept { return health_; }

  // In the order of arrival, each once.
  std::optional<wire::EventReport> take_event();

 private:
  static constexpr std::size_t kEvents = 64;  // kept until they are taken

  bool seen(std::uint32_t sequence) const noexcept;

  std::optional<wire::CalibrationPacket> calibration_;
  std::uint32_t calibration_frame_ = 0;
  std::optional<wire::HealthReport> health_;
  std::array<wire::EventReport, kEvents> events_;
  std::uint64_t events_in_ = 0;   // ever
  std::uint64_t events_out_ = 0;  // taken or given up
  bool event_seen_ = false;
  std::uint32_t newest_event_ = 0;  // sequence
  std::uint64_t older_events_ = 0;  // bit k: sequence newest_event_ - k arrived
};

}  // namespace stof::client
