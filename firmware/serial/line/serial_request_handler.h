#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/control/settings_service.h"
#include "firmware/wire/messages/announce.h"
#include "firmware/wire/messages/settings_request.h"
#include "firmware/wire/packet.h"
#include "hal/time.h"

namespace stof::firmware {

// Answers requests on a serial line: discover, and requests for settings, without a cookie,
// since whoever holds the cable is no stranger. Streams are not subscribed to: they come anyway.
// For one thread.
class SerialRequestHandler {
 public:
  struct Counters {
    std::uint64_t answered = 0;
    std::uint64_t refused = 0;  // damaged, for another device, or nothing that is answered
  };

  // settings: nullptr: every request for them is answered with kUnsupported.
  SerialRequestHandler(const wire::Origin& origin, SettingsService* settings) noexcept
      : origin_(origin), settings_(settings) {}

  // The answer to a discover; request_id is filled in here.
  void set_announce(const wire::Announce& announce, wire::Health health) noexcept;

  // Any bytes. The answer, valid until the next call; empty: none.
  std::span<const std::byte> take(std::span<const std::byte> bytes, hal::Time now) noexcept;

  const Counters& counters() const noexcept { return counters_; }

 private:
  std::span<const std::byte> discover(std::span<const std::byte> payload) noexcept;
  std::span<const std::byte> serve_settings(std::span<const std::byte> payload,
                                            hal::Time now) noexcept;
  std::span<const std::byte> seal(wire::PacketType type, std::size_t payload_bytes) noexcept;
  std::span<const std::byte> refuse() noexcept;

  wire::Origin origin_;
  SettingsService* settings_;
  wire::Announce announce_{};
  wire::Health health_ = wire::Health::kOk;
  wire::DatagramBuffer buffer_{};
  Counters counters_;
};

}  // namespace stof::firmware
