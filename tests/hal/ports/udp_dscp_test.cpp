#include <array>
#include <chrono>
#include <cstring>
#include <memory>

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "hal/linux/ports/udp_port.h"
#include "posix/poll.h"
#include "posix/udp_socket.h"
#include "tests/support/loopback.h"

namespace stof::test {
namespace {

using hal::Peer;
using hal::linux::UdpPort;

// A plain socket that is told each datagram's class.
class Listener {
 public:
  explicit Listener(int family) : socket_(family) {
    static_cast<void>(socket_.set({IPPROTO_IP, IP_RECVTOS, 1}));
    static_cast<void>(socket_.set({IPPROTO_IPV6, IPV6_RECVTCLASS, 1}));
    bound_ = socket_.bind(family == AF_INET6 ? posix::make_address(in6addr_loopback, 0)
                                             : loopback_address(0)) == 0;
  }

  bool bound() const { return bound_; }
  std::uint16_t port() const { return socket_.port(); }
  // Of the next datagram; -1: none, or it does not say.
  int next_class() const {
    std::array wait{pollfd{.fd = socket_.fd(), .events = POLLIN, .revents = 0}};
    if (posix::wait_for(wait, std::chrono::minutes(1)) != 1) {
      return -1;
    }
    std::array<std::byte, 64> bytes{};
    alignas(cmsghdr) std::array<std::byte, 128> control{};
    iovec vector{.iov_base = bytes.data(), .iov_len = bytes.size()};
    msghdr message{};
    message.msg_iov = &vector;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    if (recvmsg(socket_.fd(), &message, 0) < 0) {
      return -1;
    }
    for (cmsghdr* entry = CMSG_FIRSTHDR(&message); entry != nullptr;
         entry = CMSG_NXTHDR(&message, entry)) {
      if (entry->cmsg_level == IPPROTO_IP && entry->cmsg_type == IP_TOS) {
        return std::to_integer<int>(*reinterpret_cast<std::byte*>(CMSG_DATA(entry)));  // NOLINT
      }
      if (entry->cmsg_level == IPPROTO_IPV6 && entry->cmsg_type == IPV6_TCLASS) {
        int value = -1;
        std::memcpy(&value, CMSG_DATA(entry), sizeof value);
        return value;
      }
    }
    return -1;
  }

 private:
  posix::UdpSocket socket_;
  bool bound_ = false;
};

int class_that_arrives(UdpPort& port, int family, const Listener& listener) {
  Peer to{.address = {}, .port = listener.port()};
  if (family == AF_INET6) {
    to.address[15] = 1;
  } else {
    to.address = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 127, 0, 0, 1};
  }
  const std::array<std::byte, 4> bytes{};
  const std::span<const std::byte> datagram = bytes;
  std::size_t sent = 0;
  EXPECT_EQ(port.send(to, std::span(&datagram, 1), sent), Status::kOk);
  return listener.next_class();
}

TEST(UdpPortClass, IsThatOfEveryDatagramOfBothFamilies) {
  for (const int dscp : {0, 34, 46, 63}) {
    const auto port = UdpPort::open({.dscp = dscp});
    ASSERT_TRUE(port) << port.error().message;
    const Listener four(AF_INET);
    ASSERT_TRUE(four.bound());
    EXPECT_EQ(class_that_arrives(**port, AF_INET, four), dscp << 2);
    const Listener six(AF_INET6);
    if (six.bound()) {
      EXPECT_EQ(class_that_arrives(**port, AF_INET6, six), dscp << 2);
    }
  }
}

TEST(UdpPortClass, IsSetWhereThereIsOnlyIpv4) {
  const auto port = UdpPort::open({.ipv4_only = true, .dscp = 46});
  ASSERT_TRUE(port);
  const Listener four(AF_INET);
  EXPECT_EQ(class_that_arrives(**port, AF_INET, four), 46 << 2);
}

TEST(UdpPortClass, OutsideOfSixBitsIsRefused) {
  for (const int dscp : {-1, 64, 256}) {
    const auto port = UdpPort::open({.dscp = dscp});
    ASSERT_FALSE(port);
    EXPECT_NE(port.error().message.find("give 0 to 63"), std::string::npos);
  }
}

}  // namespace
}  // namespace stof::test
