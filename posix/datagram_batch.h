#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <expected>
#include <optional>
#include <span>

#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include "posix/socket_address.h"

namespace stof::posix {

// Room for the datagrams that one system call reads. Some 140 KB; does not move.
class DatagramBatch {
 public:
  static constexpr std::size_t kMost = 64;
  // More than a datagram of ours may have, so that one that is too long shows.
  static constexpr std::size_t kSpace = 2048;

  DatagramBatch() noexcept;
  DatagramBatch(const DatagramBatch&) = delete;
  DatagramBatch& operator=(const DatagramBatch&) = delete;

  // Reads what has come to a UDP socket, without blocking: how many datagrams there are now, each
  // valid until the next call; or an errno, EAGAIN: nothing.
  std::expected<std::size_t, int> read(int fd) noexcept;

  // index: below what read() returned.
  std::span<const std::byte> datagram(std::size_t index) const noexcept;  // up to kSpace bytes
  std::size_t whole_size(std::size_t index) const noexcept { return messages_[index].msg_len; }
  const SocketAddress& from(std::size_t index) const noexcept { return from_[index]; }
  // When it reached this machine, by CLOCK_REALTIME; none: the socket does not stamp arrivals.
  std::optional<std::chrono::nanoseconds> arrived(std::size_t index) const noexcept {
    return arrived_[index];
  }

  // The address of this machine that it was sent to, an IPv4 one mapped; ::, where the socket does
  // not tell (UdpSocket::tell_own_address()) or it went to many.
  const in6_addr& own(std::size_t index) const noexcept { return own_[index]; }
  // The interface by which it came to all hosts of its link (255.255.255.255); 0: to this machine,
  // or the socket does not tell.
  unsigned link(std::size_t index) const noexcept { return links_[index]; }

  // Datagrams that found the buffer full, where the socket counts them. Any thread may ask.
  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::size_t kControlSpace = 144;
  static_assert(kControlSpace % alignof(cmsghdr) == 0);
  static_assert(kControlSpace >= CMSG_SPACE(sizeof(std::uint32_t)) + CMSG_SPACE(sizeof(timespec)) +
                                     CMSG_SPACE(sizeof(in_pktinfo)) +
                                     CMSG_SPACE(sizeof(in6_pktinfo)));

  void read_control(msghdr& message, std::size_t index) noexcept;
  void read_own(const cmsghdr& entry, std::size_t index) noexcept;
  void note_drops(const cmsghdr& entry) noexcept;

  std::array<std::array<std::byte, kSpace>, kMost> space_;
  alignas(cmsghdr) std::array<std::array<std::byte, kControlSpace>, kMost> control_;
  std::array<SocketAddress, kMost> from_;
  std::array<std::optional<std::chrono::nanoseconds>, kMost> arrived_;
  std::array<in6_addr, kMost> own_;
  std::array<unsigned, kMost> links_;
  std::array<iovec, kMost> vectors_;
  std::array<mmsghdr, kMost> messages_;
  std::uint32_t kernel_count_ = 0;  // of drops, wraps
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace stof::posix
