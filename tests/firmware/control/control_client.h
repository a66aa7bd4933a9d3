#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "hal/linux/ports/peer_address.h"
#include "posix/udp_socket.h"
#include "tests/firmware/control/requests.h"
#include "tests/firmware/control/sensor.h"

namespace stof::test {

// Sends what UdpPort would refuse to.
class RawSocket {
 public:
  bool send(const hal::Peer& to, std::span<const std::byte> datagram) const {
    const auto address = hal::linux::to_socket_address(to, AF_INET);
    return address && socket_.send_to(*address, datagram) == 0;
  }

 private:
  posix::UdpSocket socket_{AF_INET};
};

// The other end, written by hand: one UDP port that asks a sensor on loopback.
class ControlClient {
 public:
  explicit ControlClient(const Sensor& sensor) : to_(loopback(sensor.number())) {
    auto port = hal::linux::UdpPort::open({.ipv4_only = true});
    if (!port) {
      ADD_FAILURE() << port.error().message;
      std::abort();
    }
    port_ = std::move(*port);
  }

  Status send(std::span<const std::byte> datagram) {
    std::size_t sent = 0;
    return port_->send(to_, std::span(&datagram, 1), sent);
  }
  // Also what is no datagram of ours. False: the system did not take it.
  bool send_any(std::span<const std::byte> datagram) { return raw_.send(to_, datagram); }
  std::optional<Bytes> receive(hal::Duration timeout = std::chrono::seconds(60)) {
    Bytes space(wire::kMaxDatagram);
    const Result<hal::Received> received = port_->receive(space, timeout);
    if (!received) {
      return std::nullopt;
    }
    space.resize(received->bytes);
    return space;
  }
  // Asks with the newest cookie, and once more where it was too old. kFull and the like as told.
  std::optional<wire::SubscribeResult> ask(wire::PacketType type = wire::PacketType::kSubscribe,
                                           std::uint16_t lease_ms = 0) {
    for (int i = 0; i < 3; ++i) {
      if (send(test::subscribe({.request_id = ++request_, .lease_ms = lease_ms, .cookie = cookie_},
                               type)) != Status::kOk) {
        return std::nullopt;
      }
      const std::optional<Bytes> bytes = receive();
      const std::optional<wire::Subscribed> answer = bytes ? subscribed(*bytes) : std::nullopt;
      if (!answer || answer->request_id != request_) {
        return std::nullopt;
      }
      cookie_ = answer->cookie;
      if (answer->result != wire::SubscribeResult::kCookie) {
        return answer->result;
      }
    }
    return std::nullopt;
  }

 private:
  RawSocket raw_;
  hal::Peer to_;
  std::unique_ptr<hal::linux::UdpPort> port_;
  std::uint32_t request_ = 0;
  std::uint64_t cookie_ = 0;
};

}  // namespace stof::test
