#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/status.h"
#include "hal/datagram_size.h"
#include "hal/time.h"

namespace stof::hal {

// Where a datagram comes from or goes to: an IPv6 address, or an IPv4 address mapped into one
// (::ffff:a.b.c.d), as the network writes them.
struct Peer {
  std::array<std::uint8_t, 16> address{};
  std::uint16_t port = 0;   // 1 .. 65535
  std::uint32_t scope = 0;  // interface of a link-local IPv6 address, or of 255.255.255.255; else 0
  // The address of this machine that it speaks to, and is answered from, where there are several;
  // all zero: the system's choice. No part of who it is.
  std::array<std::uint8_t, 16> own{};

  friend bool operator==(const Peer& a, const Peer& b) noexcept {
    return a.address == b.address && a.port == b.port && a.scope == b.scope;
  }
};

struct Received {
  std::size_t bytes = 0;
  Peer from;
  // The interface by which it came to all hosts of its link, 255.255.255.255; 0: it came to this
  // machine, or nobody knows.
  std::uint32_t link = 0;
};

// A bound UDP port. One thread may send while another receives; neither allocates.
class DatagramPort {
 public:
  virtual ~DatagramPort() = default;

  // Sends datagrams of at most kMaxDatagram bytes to one peer, in order, each whole or not at all,
  // without blocking. Stops at the first that is not taken. Returns how many were taken in `sent`
  // and why it stopped:
  // kWouldBlock: the queue is full. kDeviceError: that peer cannot be reached now. kTooLarge: above
  // kMaxDatagram or the path's limit. kDeviceLost: reopen.
  virtual Status send(const Peer& to, std::span<const std::span<const std::byte>> datagrams,
                      std::size_t& sent) noexcept = 0;

  // As send(), for one of kStreams streams, each with a queue of its own where the system gives
  // them: what waits for one peer never keeps what is for another from being taken. That of
  // kShallowStream holds some ten datagrams only: it is soon full, and what comes by another one
  // then waits for little.
  static constexpr std::size_t kStreams = 5;
  static constexpr std::size_t kShallowStream = 4;
  virtual Status stream(std::size_t which, const Peer& to,
                        std::span<const std::span<const std::byte>> datagrams,
                        std::size_t& sent) noexcept {
    static_cast<void>(which);
    return send(to, datagrams, sent);
  }

  // The next datagram, its first space.size() bytes: `bytes` is its whole length, which may be
  // more. Blocks for `timeout` at most; 0 only looks. kTimeout, kDeviceLost.
  virtual Result<Received> receive(std::span<std::byte> space, Duration timeout) noexcept = 0;

  // Datagrams that found the receive queue full, since it was opened.
  virtual std::uint64_t overruns() const noexcept = 0;
  // A peer that answered "nobody listens here" (ICMP) since the last call, if any: one a call.
  virtual bool take_unreachable(Peer& peer) noexcept = 0;
  // Its own number.
  virtual std::uint16_t port() const noexcept = 0;
};

}  // namespace stof::hal
