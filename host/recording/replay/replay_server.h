#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <span>
#include <string>
#include <vector>

#include "firmware/wire/crypto/crypto.h"
#include "firmware/wire/datagram_sink.h"
#include "firmware/wire/packet.h"
#include "posix/socket_address.h"
#include "posix/udp_socket.h"

namespace stof::recording {

using Time = std::chrono::steady_clock::time_point;

// The end of a sensor that clients subscribe at (docs/WIRE.md, "Subscription"), for what is played
// again. It takes subscriptions, with cookies and leases as a sensor, and nothing else: it has no
// settings and no keys, gives no raw pictures, and is found by nobody who does not know where it
// is. For one thread.
class ReplayServer {
 public:
  static constexpr std::size_t kMostSubscribers = 4;

  // wire::start_crypto() has been called. Error: a line.
  static std::expected<ReplayServer, std::string> open(const std::string& address,
                                                       std::uint16_t port);

  // From now on it speaks as this one.
  void set_origin(const wire::Origin& origin) noexcept { origin_ = origin; }
  // Answers what has come, and ends leases. False: the socket failed.
  bool serve(Time now);
  // The same until then.
  bool serve_until(Time time);
  // To all subscribers. What the system does not take is lost, as on a network.
  void send(wire::Datagrams datagrams);

  std::size_t subscribers() const noexcept { return subscribers_.size(); }
  // Subscriptions that began, so far.
  std::uint64_t begun() const noexcept { return begun_; }
  std::uint16_t port() const noexcept { return socket_.port(); }

 private:
  struct Subscriber {
    posix::SocketAddress address;
    Time until;
  };

  ReplayServer() = default;
  void take(std::span<const std::byte> datagram, const posix::SocketAddress& from, Time now);
  std::uint64_t cookie_of(const posix::SocketAddress& peer, std::uint64_t slot) const;

  posix::UdpSocket socket_;
  wire::Secret secret_{};
  wire::Origin origin_{};
  std::vector<Subscriber> subscribers_;
  std::uint64_t begun_ = 0;
};

}  // namespace stof::recording
