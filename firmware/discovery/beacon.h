#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "firmware/control/link_way.h"
#include "firmware/control/periodic_task.h"
#include "firmware/wire/messages/announce.h"
#include "firmware/wire/packet.h"
#include "hal/datagram_port.h"
#include "hal/network_interfaces.h"

namespace stof::firmware {

// One packet that says who and where the sensor is, request_id as in `announce`.
std::span<const std::byte> seal_announce(const wire::Announce& announce, const wire::Origin& origin,
                                         const wire::FrameStamp& stamp,
                                         wire::DatagramBuffer& buffer) noexcept;

// Tells everybody near who and where the sensor is, once a second, by IPv4 broadcast to kLinkPort:
// to the broadcast address of each interface, which of the loopback one is 127.255.255.255, and
// from each address of all others to 255.255.255.255, which who has an address of another network
// hears, too. For the control thread. It goes out by a port of its own: the one of requests and
// streams sends to one peer at a time.
class Beacon final : public PeriodicTask {
 public:
  static constexpr hal::Duration kPeriod = std::chrono::seconds(1);
  static constexpr std::size_t kMostTargets = 32;

  // port: takes broadcasts; nullptr: nothing is sent.
  Beacon(hal::DatagramPort* port, hal::NetworkInterfaces& network) noexcept
      : port_(port), network_(network) {}

  // The announcement from now on; nothing is sent before the first call.
  void set(const wire::Announce& announce, const wire::Origin& origin,
           const wire::FrameStamp& stamp) noexcept;
  void tick(hal::Time now) noexcept override;

 private:
  struct Contents {
    wire::Announce announce;
    wire::Origin origin;
    wire::FrameStamp stamp;
  };

  hal::DatagramPort* port_;
  hal::NetworkInterfaces& network_;
  std::optional<Contents> contents_;
  std::optional<hal::Time> due_;
  std::array<hal::InterfaceAddress, kMostTargets> addresses_{};
  wire::DatagramBuffer buffer_{};
};

}  // namespace stof::firmware
