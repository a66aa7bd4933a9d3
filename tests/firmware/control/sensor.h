#pragma once

#include <array>
#include <chrono>
#include <cstdlib>
#include <memory>
#include <optional>
#include <span>

#include <gtest/gtest.h>

#include "firmware/control/control_thread.h"
#include "hal/linux/ports/udp_port.h"

namespace stof::test {

// The network end of a sensor on loopback: port, handler and thread, without a loop.
class Sensor {
 public:
  static constexpr std::uint32_t kDevice = 0x51;

  explicit Sensor(firmware::SettingsService* settings = nullptr, std::uint16_t number = 0,
                  std::uint32_t session = 1, keys::Authenticator* authenticator = nullptr)
      : origin{.device_id = kDevice, .session_id = session},
        port(open(number)),
        handler(origin, firmware::make_cookie_secret(), subscribers, settings, authenticator),
        thread(std::in_place,
               firmware::ControlParts{
                   .port = *port, .handler = handler, .subscribers = subscribers, .ring = ring}) {}

  // As the loop: the newest list.
  const firmware::ReceiverList& list() {
    while (const std::optional<firmware::ReceiverList> next = ring.pop()) {
      list_ = *next;
    }
    return list_;
  }
  // Waits until so many are subscribed. False: not within a minute.
  bool reaches(std::size_t count) {
    for (int i = 0; i < 12'000 && list().count != count; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return list().count == count;
  }
  Status send(std::span<const std::byte> datagram) {
    Status worst = Status::kOk;
    for (const hal::Peer& peer : list().all()) {
      std::size_t sent = 0;
      const Status status = port->send(peer, std::span(&datagram, 1), sent);
      worst = worst == Status::kOk ? status : worst;
    }
    return worst;
  }
  std::uint16_t number() const { return port->port(); }

  wire::Origin origin;
  std::unique_ptr<hal::linux::UdpPort> port;
  firmware::LeaseTable subscribers;
  firmware::RequestHandler handler;
  firmware::ReceiverRing ring;
  std::optional<firmware::ControlThread> thread;

 private:
  static std::unique_ptr<hal::linux::UdpPort> open(std::uint16_t number) {
    auto port = hal::linux::UdpPort::open({.port = number});
    if (!port) {
      ADD_FAILURE() << port.error().message;
      std::abort();
    }
    return std::move(*port);
  }

  firmware::ReceiverList list_;
};

inline hal::Peer loopback(std::uint16_t port) {
  return {.address = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 127, 0, 0, 1}, .port = port};
}

}  // namespace stof::test
