#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "dsp/base/status.h"
#include "host/client/arrival_clock.h"
#include "host/client/error.h"
#include "host/client/frame/frame.h"
#include "host/client/packet_source.h"
#include "posix/datagram_batch.h"
#include "posix/socket_address.h"
#include "posix/udp_socket.h"

namespace stof::client {

inline constexpr std::uint16_t kDefaultPort = 7560;

// Every address of "HOST[:PORT]", in the order to try them; at least one. HOST: a name or a number,
// an IPv6 address with a port in brackets; port kDefaultPort without. May block on a name server.
// kInvalidArgument: not such a text; kDeviceError: no such host.
std::expected<std::vector<posix::SocketAddress>, OpenError> resolve_sensor(std::string_view sensor);

// A UDP socket for what a sensor sends, which it reads many datagrams at a time. Does not move.
class SensorSocket final : public PacketSource {
 public:
  // Bound: for a sensor that sends here by itself. As Receiver::open().
  static std::expected<std::unique_ptr<SensorSocket>, OpenError> open(const std::string& address,
                                                                      std::uint16_t port,
                                                                      int buffer_bytes);
  // Connected: sends to one sensor, and reads what comes from there alone. sensor: as
  // resolve_sensor(), whose first address that there is a route to counts.
  static std::expected<std::unique_ptr<SensorSocket>, OpenError> connect(std::string_view sensor,
                                                                         int buffer_bytes);

  // Only where connected.
  Status send(std::span<const std::byte> datagram) override;

  Result<std::size_t> receive() override;
  std::span<const std::byte> packet(std::size_t index) const override {
    return batch_.datagram(index);
  }
  const posix::SocketAddress* from(std::size_t index) const override { return &batch_.from(index); }
  Time arrived(std::size_t index) const override { return arrived_[index]; }

  Status wait(Duration timeout) const override;
  bool take_refusal() override { return std::exchange(refused_, false); }

  int fd() const override { return socket_.fd(); }
  std::uint16_t port() const override { return socket_.port(); }
  // "192.168.1.20:7560", of the sensor or ours.
  const std::string& place() const override { return place_; }
  int buffer_bytes() const override { return buffer_bytes_; }
  std::uint64_t dropped() const override { return batch_.dropped(); }

 private:
  SensorSocket(posix::UdpSocket socket, std::string place, int buffer_bytes);
  bool passes(int error);
  void note_arrivals(std::size_t count, Time before);

  posix::UdpSocket socket_;
  std::string place_;
  int buffer_bytes_;
  bool refused_ = false;
  posix::DatagramBatch batch_;
  ArrivalClock clock_{ArrivalClock::now()};
  std::array<Time, posix::DatagramBatch::kMost> arrived_{};
};

}  // namespace stof::client
