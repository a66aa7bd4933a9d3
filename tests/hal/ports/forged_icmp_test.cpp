#include <array>
#include <chrono>
#include <cstdint>
#include <span>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/ip.h>
#include <netinet/ip_icmp.h>
#include <netinet/udp.h>
#include <sys/socket.h>

#include "hal/linux/ports/udp_port.h"
#include "posix/fd.h"
#include "tests/support/loopback.h"
#include "tests/support/own_network.h"
#include "tests/support/udp_abilities.h"

// Answers of the network that a stranger makes up.
namespace stof::test {
namespace {

using hal::Peer;
using hal::linux::UdpPort;

std::uint16_t internet_checksum(const std::vector<std::uint8_t>& bytes) {
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
    sum += static_cast<std::uint32_t>(bytes[i] << 8 | bytes[i + 1]);
  }
  while (sum > 0xFFFF) {
    sum = (sum & 0xFFFF) + (sum >> 16);
  }
  return static_cast<std::uint16_t>(~sum);
}

void append_u16(std::vector<std::uint8_t>& bytes, unsigned value) {
  bytes.push_back(static_cast<std::uint8_t>(value >> 8));
  bytes.push_back(static_cast<std::uint8_t>(value));
}

// As a router would answer a datagram of 1,232 bytes from 127.0.0.1, `from`, to 127.0.0.1, `to`.
bool forge(std::uint8_t code, unsigned mtu, std::uint16_t from, std::uint16_t to) {
  const posix::Fd raw(socket(AF_INET, SOCK_RAW, IPPROTO_ICMP));
  std::vector<std::uint8_t> icmp{ICMP_DEST_UNREACH, code, 0, 0};
  append_u16(icmp, 0);
  append_u16(icmp, mtu);
  icmp.insert(icmp.end(), {0x45, 0});
  append_u16(icmp, 20 + 8 + 1232);
  icmp.insert(icmp.end(), {0, 1, 0x40, 0, 64, IPPROTO_UDP, 0, 0, 127, 0, 0, 1, 127, 0, 0, 1});
  append_u16(icmp, from);
  append_u16(icmp, to);
  append_u16(icmp, 8 + 1232);
  append_u16(icmp, 0);
  const std::uint16_t sum = internet_checksum(icmp);
  icmp[2] = static_cast<std::uint8_t>(sum >> 8);
  icmp[3] = static_cast<std::uint8_t>(sum);
  const posix::SocketAddress address = loopback_address(0);
  return raw.is_open() && sendto(raw.get(), icmp.data(), icmp.size(), 0, address.generic(),
                                 address.length) == static_cast<ssize_t>(icmp.size());
}

// How many of 100 large datagrams arrive after the forged answer.
int arrive_after(std::uint8_t code, unsigned mtu) {
  const auto sensor = UdpPort::open({});
  const auto receiver = UdpPort::open({.ipv4_only = true});
  if (!sensor || !receiver) {
    return kSkipped;
  }
  const Peer to{.address = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 127, 0, 0, 1},
                .port = (*receiver)->port()};
  const std::array<std::byte, 1232> datagram{};
  const std::span<const std::byte> one(datagram);
  std::size_t sent = 0;
  static_cast<void>((*sensor)->send(to, std::span(&one, 1), sent));  // there is a route now
  if (!forge(code, mtu, (*sensor)->port(), to.port)) {
    return kSkipped;
  }
  int arrived = -1;  // the one before
  for (int i = 0; i < 100; ++i) {
    static_cast<void>((*sensor)->send(to, std::span(&one, 1), sent));
  }
  std::array<std::byte, 2000> space;
  while ((*receiver)->receive(space, std::chrono::milliseconds(200))) {
    ++arrived;
  }
  return arrived;
}

TEST(ForgedIcmp, ThatAPathTakesLessIsNotBelieved) {
  const int arrived = in_own_network([] { return arrive_after(ICMP_FRAG_NEEDED, 552); });
  if (arrived == kSkipped) {
    GTEST_SKIP() << "this user may not have a network of its own";
  }
  EXPECT_EQ(arrived, 100);
}

// Whether a port hears of a refusal that was made up.
int hears(bool refusals) {
  const auto sensor = UdpPort::open({.refusals = refusals});
  const auto receiver = UdpPort::open({.ipv4_only = true});
  if (!sensor || !receiver) {
    return kSkipped;
  }
  Peer to{.address = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 127, 0, 0, 1},
          .port = (*receiver)->port()};
  const std::array<std::byte, 100> datagram{};
  const std::span<const std::byte> one(datagram);
  std::size_t sent = 0;
  static_cast<void>((*sensor)->send(to, std::span(&one, 1), sent));  // there is a route now
  if (!forge(ICMP_PORT_UNREACH, 0, (*sensor)->port(), to.port)) {
    return kSkipped;
  }
  std::array<std::byte, 2000> space;
  static_cast<void>((*sensor)->receive(space, std::chrono::milliseconds(100)));
  return (*sensor)->take_unreachable(to) ? 1 : 0;
}

// While many of them are read each makes a call of whoever sends fail.
TEST(ForgedIcmp, OnlyWhoAsksHearsOfThem) {
  if (!tells_refusals()) {
    GTEST_SKIP() << "this system does not tell who refuses";
  }
  for (const bool refusals : {false, true}) {
    const int heard = in_own_network([refusals] { return hears(refusals); });
    if (heard == kSkipped) {
      GTEST_SKIP() << "this user may not have a network of its own";
    }
    EXPECT_EQ(heard, refusals ? 1 : 0);
  }
}

TEST(ForgedIcmp, ThatNobodyListensCostsNoDatagram) {
  const int arrived = in_own_network([] { return arrive_after(ICMP_PORT_UNREACH, 0); });
  if (arrived == kSkipped) {
    GTEST_SKIP() << "this user may not have a network of its own";
  }
  EXPECT_EQ(arrived, 100);
}

}  // namespace
}  // namespace stof::test
