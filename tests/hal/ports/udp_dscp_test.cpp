#include <array>
#include <cstring>
#include <memory>

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "hal/linux/ports/udp_port.h"

namespace stof::test {
namespace {

using hal::Peer;
using hal::linux::UdpPort;

// A plain socket that is told each datagram's class.
class Listener {
 public:
  explicit Listener(int family) : fd_(socket(family, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    const int on = 1;
    setsockopt(fd_, IPPROTO_IP, IP_RECVTOS, &on, sizeof on);
    sockaddr_storage self{};
    socklen_t length = sizeof self;
    self.ss_family = static_cast<sa_family_t>(family);
    if (family == AF_INET6) {
      setsockopt(fd_, IPPROTO_IPV6, IPV6_RECVTCLASS, &on, sizeof on);
      sockaddr_in6 six{};
      six.sin6_family = AF_INET6;
      six.sin6_addr = in6addr_loopback;
      std::memcpy(&self, &six, sizeof six);
    } else {
      sockaddr_in four{};
      four.sin_family = AF_INET;
      four.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
      std::memcpy(&self, &four, sizeof four);
    }
    bound_ = bind(fd_, reinterpret_cast<sockaddr*>(&self), length) == 0 &&  // NOLINT: sockets'
             getsockname(fd_, reinterpret_cast<sockaddr*>(&self), &length) == 0;  // NOLINT
    sockaddr_in head{};  // the port is at the same place in both
    std::memcpy(&head, &self, sizeof head);
    port_ = ntohs(head.sin_port);
  }
  ~Listener() { close(fd_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  bool bound() const { return bound_; }
  std::uint16_t port() const { return port_; }
  // Of the next datagram; -1: none, or it does not say.
  int next_class() const {
    pollfd wait{.fd = fd_, .events = POLLIN, .revents = 0};
    if (poll(&wait, 1, 5000) != 1) {
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
    if (recvmsg(fd_, &message, 0) < 0) {
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
  int fd_;
  bool bound_ = false;
  std::uint16_t port_ = 0;
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
