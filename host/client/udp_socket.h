#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include <sys/socket.h>
#include <sys/uio.h>

#include "dsp/base/status.h"
#include "host/client/frame.h"

namespace stof::client {

// A bound UDP socket that reads many datagrams in one call. Does not move.
class UdpSocket {
 public:
  // As Receiver::open(); the error is a line for a person.
  struct Error {
    Status status;
    std::string message;
  };
  static std::expected<std::unique_ptr<UdpSocket>, Error> open(const std::string& address,
                                                               std::uint16_t port,
                                                               int buffer_bytes);
  ~UdpSocket();
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;

  // Reads what has arrived, without blocking: the number of datagrams now in datagram(0 ...), which
  // are valid until the next call. kDeviceLost: the socket failed.
  Result<std::size_t> receive();
  std::span<const std::byte> datagram(std::size_t index) const;

  // Blocks until something can be read (kOk) or the time is over (kTimeout). kDeviceLost.
  Status wait(Duration timeout);

  std::uint16_t port() const { return port_; }
  int buffer_bytes() const { return buffer_bytes_; }  // granted
  std::uint64_t dropped() const { return dropped_; }  // datagrams that found the buffer full

 private:
  static constexpr std::size_t kBatch = 64;
  // More than a datagram may have, so that one that is too long shows.
  static constexpr std::size_t kSpace = 2048;
  static constexpr std::size_t kControlSpace = 64;
  static_assert(kControlSpace % alignof(cmsghdr) == 0);

  explicit UdpSocket(int fd);
  void ask_for_buffer(int bytes);
  void note_drops(const msghdr& message);

  int fd_;
  std::uint16_t port_ = 0;
  int buffer_bytes_ = 0;
  std::uint64_t dropped_ = 0;
  std::uint32_t kernel_count_ = 0;  // of drops, wraps
  std::array<std::array<std::byte, kSpace>, kBatch> space_;
  alignas(cmsghdr) std::array<std::array<std::byte, kControlSpace>, kBatch> control_;
  std::array<iovec, kBatch> vectors_;
  std::array<mmsghdr, kBatch> messages_;
};

}  // namespace stof::client
