#include "hal/linux/ports/stream_sockets.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <span>

#include <gtest/gtest.h>
#include <linux/filter.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "hal/linux/ports/udp_port.h"
#include "hal/network_interfaces.h"
#include "posix/udp_socket.h"
#include "tests/support/own_network.h"

namespace stof::test {
namespace {

using namespace std::chrono_literals;
using hal::Peer;
using hal::linux::UdpPort;

constexpr std::size_t kStreams = hal::DatagramPort::kStreams;
const std::array<std::byte, 1232> kDatagram{};

Peer loopback(std::uint16_t port) {
  return {.address = hal::from_ipv4(127, 0, 0, 1), .port = port};
}

Status stream_one(UdpPort& port, std::size_t which, const Peer& to) {
  const std::span<const std::byte> one(kDatagram);
  std::size_t sent = 0;
  return port.stream(which, to, std::span(&one, 1), sent);
}

std::unique_ptr<UdpPort> open_with_streams(int buffer_bytes = 1 << 20) {
  auto port = UdpPort::open({.buffer_bytes = buffer_bytes, .streams = true});
  return port ? std::move(*port) : nullptr;
}

int arrived(UdpPort& port) {
  std::array<std::byte, 2000> space;
  int count = 0;
  while (port.receive(space, 200ms)) {
    ++count;
  }
  return count;
}

// Whether the system can be told which of several sockets at a port receives.
bool says_who_receives() {
  const posix::UdpSocket probe(AF_INET);
  sock_filter first{.code = BPF_RET | BPF_K, .jt = 0, .jf = 0, .k = 0};
  const sock_fprog program{.len = 1, .filter = &first};
  return probe.set({SOL_SOCKET, SO_REUSEPORT, 1}) == 0 &&
         setsockopt(probe.fd(), SOL_SOCKET, SO_ATTACH_REUSEPORT_CBPF, &program, sizeof program) ==
             0;
}

TEST(StreamSockets, AreThereWhereTheSystemSaysWhoReceives) {
  const auto sensor = open_with_streams();
  ASSERT_NE(sensor, nullptr);
  EXPECT_EQ(sensor->streams_have_queues(), says_who_receives());
}

// The system must not hand a request to a socket that nobody reads.
TEST(StreamSockets, EveryRequestArrivesWhoeverSendsIt) {
  const auto sensor = open_with_streams();
  ASSERT_NE(sensor, nullptr);
  constexpr int kSenders = 100;
  for (int i = 0; i < kSenders; ++i) {
    const auto sender = UdpPort::open({.ipv4_only = i % 2 == 0});
    ASSERT_TRUE(sender);
    EXPECT_EQ(stream_one(**sender, 0, loopback(sensor->port())), Status::kOk);
  }
  EXPECT_EQ(arrived(*sensor), kSenders);
}

TEST(StreamSockets, EachSendsFromTheNumberOfThePort) {
  const auto sensor = open_with_streams();
  const auto robot = UdpPort::open({});
  ASSERT_TRUE(sensor && robot);
  for (std::size_t which = 0; which <= kStreams; ++which) {  // there is none for the last
    EXPECT_EQ(stream_one(*sensor, which, loopback((*robot)->port())), Status::kOk);
    std::array<std::byte, 2000> space;
    const auto received = (*robot)->receive(space, 60s);
    ASSERT_TRUE(received);
    EXPECT_EQ(received->from, loopback(sensor->port()));
    EXPECT_EQ(received->bytes, kDatagram.size());
  }
}

TEST(StreamSockets, APortInUseStaysRefused) {
  const auto first = open_with_streams();
  ASSERT_NE(first, nullptr);
  EXPECT_FALSE(UdpPort::open({.port = first->port(), .streams = true}));
  // Nor does it help to share: another program of this user would take the requests.
  for (const in_addr_t host : {INADDR_ANY, INADDR_LOOPBACK}) {
    const posix::UdpSocket other(AF_INET);
    ASSERT_EQ(other.set({SOL_SOCKET, SO_REUSEPORT, 1}), 0);
    const in_addr at{.s_addr = htonl(host)};
    EXPECT_EQ(other.bind(posix::make_address(at, first->port())), EADDRINUSE);
  }
}

TEST(StreamSockets, RequestsArriveWhereThereIsOnlyIpv4) {
  auto sensor = UdpPort::open({.ipv4_only = true, .streams = true});
  const auto robot = UdpPort::open({});
  ASSERT_TRUE(sensor && robot);
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(stream_one(**robot, 0, loopback((*sensor)->port())), Status::kOk);
  }
  EXPECT_EQ(arrived(**sensor), 10);
}

// An address that answers no ARP: Linux keeps what is sent there for three seconds.
bool make_silent_neighbour() {
  return std::system(
             "ip link add to type veth peer name from 2>/dev/null &&"
             " ip addr add 10.76.0.1/24 dev to && ip link set to up &&"
             " ip link set from up") == 0;
}

// How many of ten arrive after a silent neighbour has filled its queue. A network of its own.
int arrive_beside_silence(bool streams) {
  constexpr int kSmall = 100'000;
  const auto sensor = UdpPort::open({.buffer_bytes = kSmall, .streams = streams});
  const auto robot = UdpPort::open({.ipv4_only = true});
  if (!sensor || !robot || !make_silent_neighbour() ||
      streams != (*sensor)->streams_have_queues()) {
    return kSkipped;
  }
  const Peer silent{.address = hal::from_ipv4(10, 76, 0, 77), .port = 9};
  Status status = Status::kOk;
  for (int i = 0; i < 1000 && status == Status::kOk; ++i) {
    status = stream_one(**sensor, 1, silent);
  }
  if (status != Status::kWouldBlock) {
    return kSkipped;
  }
  for (int i = 0; i < 10; ++i) {
    static_cast<void>(stream_one(**sensor, 0, loopback((*robot)->port())));
  }
  return arrived(**robot);
}

TEST(StreamSockets, WhoDoesNotResolveKeepsNobodyElseWaiting) {
  const int with = in_own_network([] { return arrive_beside_silence(true); });
  const int without = in_own_network([] { return arrive_beside_silence(false); });
  if (with == kSkipped || without == kSkipped) {
    GTEST_SKIP() << "this user may not have a network of its own, or the system has one queue";
  }
  EXPECT_EQ(with, 10);
  EXPECT_EQ(without, 0) << "the queue of all was not full: this proves nothing";
}

// How many datagrams a stream's queue holds for a neighbour that never answers.
int held_for_silence(std::size_t which) {
  const auto sensor = UdpPort::open({.buffer_bytes = 100'000, .streams = true});
  if (!sensor || !(*sensor)->streams_have_queues() || !make_silent_neighbour()) {
    return kSkipped;
  }
  const Peer silent{.address = hal::from_ipv4(10, 76, 0, 77), .port = 9};
  for (int held = 0; held < 1000; ++held) {
    if (stream_one(**sensor, which, silent) == Status::kWouldBlock) {
      return held;
    }
  }
  return kSkipped;
}

// What a packet of depth may have to wait behind: some ten datagrams, 1.5 ms at 100 Mbit/s.
TEST(StreamSockets, TheShallowOneIsSoonFull) {
  const int shallow = in_own_network([] { return held_for_silence(UdpPort::kShallowStream); });
  const int usual = in_own_network([] { return held_for_silence(0); });
  if (shallow == kSkipped || usual == kSkipped) {
    GTEST_SKIP() << "this user may not have a network of its own, or the system has one queue";
  }
  EXPECT_GE(shallow, 8) << "a burst of raw pictures";
  EXPECT_LE(shallow, 20);
  EXPECT_GT(usual, 2 * shallow);
}

}  // namespace
}  // namespace stof::test
