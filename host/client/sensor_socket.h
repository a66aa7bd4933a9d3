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
class SensorSocket {
 public:
  // Bound: for a sensor that sends here by itself. As Receiver::open().
  static std::expected<std::unique_ptr<SensorSocket>, OpenError> open(const std::string& address,
                                                                      std::uint16_t port,
                                                                      int buffer_bytes);
  // Connected: sends to one sensor, and reads what comes from there alone. sensor: as
  // resolve_sensor(), whose first address that there is a route to counts.
  static std::expected<std::unique_ptr<SensorSocket>, OpenError> connect(std::string_view sensor,
                                                                         int buffer_bytes);

  // One datagram to the sensor, without blocking; only where connected. kWouldBlock: the buffer is
  // full; kDeviceError: no way to the sensor now; kDeviceLost.
  Status send(std::span<const std::byte> datagram);

  // Reads what has arrived, without blocking: the number of datagrams now in datagram(0 ...), which
  // are valid until the next call. kDeviceLost: the socket failed.
  Result<std::size_t> receive();
  std::span<const std::byte> datagram(std::size_t index) const { return batch_.datagram(index); }
  // Who sent it.
  const posix::SocketAddress& from(std::size_t index) const { return batch_.from(index); }
  // When it reached this machine; when it was read, where the system does not stamp arrivals.
  Time arrived(std::size_t index) const { return arrived_[index]; }

  // Blocks until something can be read (kOk) or the time is over (kTimeout). kDeviceLost.
  Status wait(Duration timeout) const;
  // Whether the sensor's computer answered that nobody listens there, since the last call.
  bool take_refusal() { return std::exchange(refused_, false); }

  // Becomes readable when receive() has something to do.
  int fd() const { return socket_.fd(); }
  std::uint16_t port() const { return socket_.port(); }
  const std::string& place() const { return place_; }  // "192.168.1.20:7560", of the sensor or ours
  int buffer_bytes() const { return buffer_bytes_; }   // granted
  std::uint64_t dropped() const { return batch_.dropped(); }  // datagrams that found it full

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
