#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include <sys/socket.h>
#include <sys/uio.h>

#include "dsp/base/status.h"
#include "host/client/error.h"
#include "host/client/frame/frame.h"
#include "host/client/sensor_address.h"

namespace stof::client {

// A UDP socket that reads many datagrams in one call. Does not move.
class UdpSocket {
 public:
  // Bound: for a sensor that sends here by itself. As Receiver::open().
  static std::expected<std::unique_ptr<UdpSocket>, OpenError> open(const std::string& address,
                                                                   std::uint16_t port,
                                                                   int buffer_bytes);
  // Connected: sends to one sensor, and reads what comes from there alone. sensor: as
  // resolve_sensor(), whose first address that there is a route to counts.
  static std::expected<std::unique_ptr<UdpSocket>, OpenError> connect(std::string_view sensor,
                                                                      int buffer_bytes);
  ~UdpSocket();
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;

  // One datagram to the sensor, without blocking; only where connected. kWouldBlock: the buffer is
  // full; kDeviceError: no way to the sensor now; kDeviceLost.
  Status send(std::span<const std::byte> datagram);

  // Reads what has arrived, without blocking: the number of datagrams now in datagram(0 ...), which
  // are valid until the next call. kDeviceLost: the socket failed.
  Result<std::size_t> receive();
  std::span<const std::byte> datagram(std::size_t index) const;

  // Blocks until something can be read (kOk) or the time is over (kTimeout). kDeviceLost.
  Status wait(Duration timeout);
  // Whether the sensor's computer answered that nobody listens there, since the last call.
  bool take_refusal() { return std::exchange(refused_, false); }

  // Becomes readable when receive() has something to do.
  int fd() const { return fd_; }
  std::uint16_t port() const { return port_; }
  const std::string& place() const { return place_; }  // "192.168.1.20:7560", of the sensor or ours
  int buffer_bytes() const { return buffer_bytes_; }   // granted
  std::uint64_t dropped() const { return dropped_; }   // datagrams that found the buffer full

 private:
  static constexpr std::size_t kBatch = 64;
  // More than a datagram may have, so that one that is too long shows.
  static constexpr std::size_t kSpace = 2048;
  static constexpr std::size_t kControlSpace = 64;
  static_assert(kControlSpace % alignof(cmsghdr) == 0);

  explicit UdpSocket(int fd);
  void prepare(int buffer_bytes);
  void note_drops(const msghdr& message);

  int fd_;
  std::uint16_t port_ = 0;
  std::string place_;
  bool refused_ = false;
  int buffer_bytes_ = 0;
  std::uint64_t dropped_ = 0;
  std::uint32_t kernel_count_ = 0;  // of drops, wraps
  std::array<std::array<std::byte, kSpace>, kBatch> space_;
  alignas(cmsghdr) std::array<std::array<std::byte, kControlSpace>, kBatch> control_;
  std::array<iovec, kBatch> vectors_;
  std::array<mmsghdr, kBatch> messages_;
};

}  // namespace stof::client
