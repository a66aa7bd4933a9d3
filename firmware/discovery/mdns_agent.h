#pragma once

#include <array>
#include <cstddef>

#include "firmware/control/periodic_task.h"
#include "firmware/discovery/mdns.h"
#include "hal/network_interfaces.h"

namespace stof::firmware {

// The responder at its port. For the control thread. A machine without network is no error: it
// looks again every two seconds.
class MdnsAgent final : public PeriodicTask {
 public:
  MdnsAgent(hal::MulticastPort& port, hal::NetworkInterfaces& network, const Service& service,
            std::uint32_t seed) noexcept
      : port_(port), network_(network), responder_(service, seed) {}

  void tick(hal::Time now) noexcept override;
  // Takes effect within a second or two.
  void set_service(const Service& service, hal::Time now) noexcept {
    responder_.set_service(service, now);
  }
  // Says goodbye, at once. Nothing is to be called after it.
  void stop(hal::Time now) noexcept;

  const Responder& responder() const noexcept { return responder_; }

 private:
  void send(const Responder::Datagram& datagram) noexcept;
  void send_due(hal::Time now) noexcept;

  hal::MulticastPort& port_;
  hal::NetworkInterfaces& network_;
  Responder responder_;
  hal::Time look_due_{};
  std::array<hal::InterfaceAddress, MdnsLinks::kMostAddresses> addresses_{};
  // RFC 6762 section 17 allows 9,000 bytes; what is longer is read up to here, which holds its
  // questions.
  std::array<std::byte, 4096> buffer_{};
};

}  // namespace stof::firmware
