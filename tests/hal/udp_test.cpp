#include <algorithm>
#include <array>
#include <optional>
#include <string>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "hal/linux/link_udp.h"

namespace stof::test {
namespace {

using hal::posix::UdpLink;

// A receiver on the loopback interface, on a port of the kernel's choice.
class Receiver {
 public:
  explicit Receiver(int family) : fd_(socket(family, SOCK_DGRAM, 0)) {
    if (family == AF_INET6) {
      sockaddr_in6 address{};
      address.sin6_family = AF_INET6;
      address.sin6_addr = in6addr_loopback;
      bind_to(address);
    } else {
      sockaddr_in address{};
      address.sin_family = AF_INET;
      address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
      bind_to(address);
    }
    const timeval patience{.tv_sec = 5, .tv_usec = 0};
    setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  }
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;
  ~Receiver() { close(); }

  void close() {
    if (fd_ >= 0) {
      ::close(fd_);
      fd_ = -1;
    }
  }
  bool bound() const { return port_ != 0; }
  std::string port() const { return std::to_string(port_); }
  std::optional<std::string> receive() const {
    std::string bytes(65536, '\0');
    const ssize_t count = recv(fd_, bytes.data(), bytes.size(), 0);
    if (count < 0) {
      return std::nullopt;
    }
    bytes.resize(static_cast<std::size_t>(count));
    return bytes;
  }

 private:
  template <typename Address>
  void bind_to(Address& address) {
    socklen_t size = sizeof address;
    sockaddr* const any = reinterpret_cast<sockaddr*>(&address);
    if (bind(fd_, any, size) == 0 && getsockname(fd_, any, &size) == 0) {
      // The port stands at the same place in both families.
      port_ = ntohs(reinterpret_cast<sockaddr_in*>(&address)->sin_port);
    }
  }

  int fd_;
  int port_ = 0;
};

Status send(hal::Link& link, const std::string& text) {
  return link.send(std::as_bytes(std::span(text)));
}

TEST(UdpLink, DeliversEachDatagramWhole) {
  const Receiver receiver(AF_INET);
  ASSERT_TRUE(receiver.bound());
  auto link = UdpLink::open("127.0.0.1:" + receiver.port());
  ASSERT_TRUE(link) << link.error().message;
  for (const std::string& datagram : {std::string("hello"), std::string(hal::kMaxDatagram, 'x'),
                                      std::string(), std::string("\0\n\xff", 3)}) {
    ASSERT_EQ(send(*link, datagram), Status::kOk);
    EXPECT_EQ(receiver.receive(), datagram);
  }
}

TEST(UdpLink, FindsNamesAndIpv6Addresses) {
  const Receiver receiver(AF_INET);
  auto named = UdpLink::open("localhost:" + receiver.port());
  ASSERT_TRUE(named) << named.error().message;
  const Receiver six(AF_INET6);
  if (!six.bound()) {
    return;  // a machine without IPv6
  }
  auto link = UdpLink::open("[::1]:" + six.port());
  ASSERT_TRUE(link) << link.error().message;
  ASSERT_EQ(send(*link, "six"), Status::kOk);
  EXPECT_EQ(six.receive(), "six");
}

TEST(UdpLink, SurvivesBeingMoved) {
  const Receiver receiver(AF_INET);
  auto first = UdpLink::open("127.0.0.1:" + receiver.port());
  auto second = UdpLink::open("127.0.0.1:" + receiver.port());
  ASSERT_TRUE(first && second);
  *second = std::move(*first);
  UdpLink third(std::move(*second));
  ASSERT_EQ(send(third, "moved"), Status::kOk);
  EXPECT_EQ(receiver.receive(), "moved");
}

TEST(UdpLink, RefusesWhatIsTooLarge) {
  const Receiver receiver(AF_INET);
  auto link = UdpLink::open("127.0.0.1:" + receiver.port());
  ASSERT_TRUE(link);
  EXPECT_EQ(send(*link, std::string(hal::kMaxDatagram + 1, 'x')), Status::kTooLarge);
}

TEST(UdpLink, TellsWhenNobodyListensAndLosesNothingWhenSomebodyDoes) {
  Receiver receiver(AF_INET);
  const std::string port = receiver.port();
  auto link = UdpLink::open("127.0.0.1:" + port);
  ASSERT_TRUE(link);
  receiver.close();
  EXPECT_EQ(send(*link, "1"), Status::kOk);  // the refusal comes as an answer
  EXPECT_EQ(send(*link, "2"), Status::kDeviceError);
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(std::stoi(port)));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  EXPECT_EQ(send(*link, "3"), Status::kDeviceError);  // answers "2", but is sent
  EXPECT_EQ(send(*link, "4"), Status::kOk);
  char byte = 0;
  EXPECT_EQ(recv(fd, &byte, 1, 0), 1);
  EXPECT_EQ(byte, '3');
  ::close(fd);
}

TEST(UdpLink, RefusesBadDestinationsInOneLine) {
  for (const std::string bad :
       {"", "127.0.0.1", ":5600", "127.0.0.1:", "127.0.0.1:0", "127.0.0.1:65536", "127.0.0.1:56x",
        "127.0.0.1:-1", "::1:5600", "[]:5600", "a..b:5600"}) {
    const auto link = UdpLink::open(bad);
    ASSERT_FALSE(link) << bad;
    const std::string& message = link.error().message;
    EXPECT_NE(message.find("'" + bad + "'"), std::string::npos) << message;
    EXPECT_EQ(std::ranges::count(message, '\n'), 0);
  }
}

}  // namespace
}  // namespace stof::test
