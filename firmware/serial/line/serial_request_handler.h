#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/control/request_handler.h"
#include "firmware/control/settings_service.h"
#include "firmware/wire/messages/announce.h"
#include "firmware/wire/messages/settings_request.h"
#include "firmware/wire/packet.h"
#include "hal/time.h"

namespace stof::firmware {

// Answers requests on a serial line: discover, and requests for settings, without a cookie or a
// key, since whoever holds the cable is no stranger. What a key signs is judged by that key. Where
// the line leads to strangers (a telemetry radio), all requests for settings are judged as those of
// the network, as if its other end were one host. Streams are not subscribed to: they come anyway.
// For one thread.
class SerialRequestHandler {
 public:
  struct Counters {
    std::uint64_t answered = 0;
    std::uint64_t refused = 0;  // damaged, for another device, or nothing that is answered
  };

  // settings: nullptr: every request for them is answered with kUnsupported. strangers: judges
  // those of a remote line; nullptr: none is answered there. Both outlive it.
  SerialRequestHandler(const wire::Origin& origin, SettingsService* settings,
                       RequestHandler* strangers = nullptr) noexcept
      : origin_(origin), settings_(settings), strangers_(strangers) {}

  // Who serves requests to pair, on a line that is not remote; outlives it.
  void set_pairing(keys::PairingServer* pairing) noexcept { pairing_ = pairing; }
  // Whether strangers are at the other end; at first they are not.
  void set_remote(bool remote) noexcept { remote_ = remote; }

  // The answer to a discover; request_id is filled in here.
  void set_announce(const wire::Announce& announce, wire::Health health) noexcept;

  // Any bytes. The answer, valid until the next call; empty: none.
  std::span<const std::byte> take(std::span<const std::byte> bytes, hal::Time now) noexcept;

  const Counters& counters() const noexcept { return counters_; }

 private:
  std::span<const std::byte> discover(std::span<const std::byte> payload) noexcept;
  std::span<const std::byte> serve_settings(std::span<const std::byte> payload,
                                            hal::Time now) noexcept;
  std::span<const std::byte> pair(std::span<const std::byte> payload, hal::Time now) noexcept;
  std::span<const std::byte> pass_on(std::span<const std::byte> bytes, hal::Time now) noexcept;
  std::span<const std::byte> seal(wire::PacketType type, std::size_t payload_bytes) noexcept;
  std::span<const std::byte> refuse() noexcept;

  wire::Origin origin_;
  SettingsService* settings_;
  RequestHandler* strangers_;
  keys::PairingServer* pairing_ = nullptr;
  bool remote_ = false;
  wire::Announce announce_{};
  wire::Health health_ = wire::Health::kOk;
  wire::DatagramBuffer buffer_{};
  Counters counters_;
};

}  // namespace stof::firmware
