#include "hal/linux/ports/udp_port.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <net/if.h>

#include "hal/linux/ports/peer_address.h"
#include "hal/network_interfaces.h"
#include "tests/support/loopback.h"
#include "tests/support/udp_abilities.h"

namespace stof::test {
namespace {

using namespace std::chrono_literals;
using hal::Peer;
using hal::linux::resolve;
using hal::linux::UdpPort;
using hal::linux::UdpPortOptions;

std::unique_ptr<UdpPort> open_port(const UdpPortOptions& options = {}) {
  auto port = UdpPort::open(options);
  if (!port) {
    ADD_FAILURE() << port.error().message;
    std::abort();
  }
  return std::move(*port);
}

Peer local(std::uint16_t port) {
  return {.address = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 127, 0, 0, 1}, .port = port};
}
Peer local6(std::uint16_t port) {
  return {.address = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}, .port = port};
}

Status send(UdpPort& port, const Peer& to, std::string_view text) {
  const std::span<const std::byte> datagram = std::as_bytes(std::span(text));
  std::size_t sent = 0;
  const Status status = port.send(to, std::span(&datagram, 1), sent);
  EXPECT_EQ(sent, status == Status::kOk ? 1U : 0U);
  return status;
}

struct Heard {
  std::string text;
  Peer from;
};

Heard receive(UdpPort& port, hal::Duration timeout = 60s) {
  std::array<std::byte, 2000> space;
  const Result<hal::Received> received = port.receive(space, timeout);
  if (!received) {
    return {.text = to_string(received.error()), .from = {}};
  }
  std::string text;
  for (const std::byte byte : std::span(space).first(std::min(received->bytes, space.size()))) {
    text += static_cast<char>(byte);
  }
  return {.text = text, .from = received->from};
}

// Waits for ICMP's answer, which a busy kernel may bring late.
bool hears_refusal(UdpPort& port, Peer& peer) {
  for (int i = 0; i < 6000; ++i) {
    std::array<std::byte, 64> space;
    static_cast<void>(port.receive(space, 10ms));
    if (port.take_unreachable(peer)) {
      return true;
    }
  }
  return false;
}

TEST(UdpPort, DeliversEachDatagramWholeAndSaysFromWhere) {
  const auto one = open_port();
  const auto two = open_port();
  for (const std::string& datagram : {std::string("hello"), std::string(hal::kMaxDatagram, 'x'),
                                      std::string(), std::string("\0\n\xff", 3)}) {
    ASSERT_EQ(send(*one, local(two->port()), datagram), Status::kOk);
    const Heard heard = receive(*two);
    EXPECT_EQ(heard.text, datagram);
    EXPECT_EQ(heard.from, local(one->port()));
  }
}

TEST(UdpPort, AnswersIpv6AndIpv4FromOnePort) {
  const auto sensor = open_port();
  const auto four = open_port({.ipv4_only = true});
  const auto six = open_port();
  ASSERT_EQ(send(*four, local(sensor->port()), "four"), Status::kOk);
  const Heard first = receive(*sensor);
  EXPECT_EQ(first.from, local(four->port()));
  ASSERT_EQ(send(*sensor, first.from, "back"), Status::kOk);
  EXPECT_EQ(receive(*four).text, "back");
  if (send(*six, local6(sensor->port()), "six") != Status::kOk) {
    GTEST_SKIP() << "a machine without IPv6";
  }
  const Heard second = receive(*sensor);
  EXPECT_EQ(second.from, local6(six->port()));
  ASSERT_EQ(send(*sensor, second.from, "back"), Status::kOk);
  EXPECT_EQ(receive(*six).text, "back");
  EXPECT_EQ(send(*four, local6(sensor->port()), "no way"), Status::kDeviceError);
}

// All of 127.0.0.0/8 are addresses of this machine.
TEST(UdpPort, AnswersFromTheAddressThatWasAsked) {
  if (!tells_own_address()) {
    GTEST_SKIP() << "this system does not tell where a datagram was sent to";
  }
  const auto robot = open_port();
  for (const bool ipv4_only : {false, true}) {
    const auto sensor = open_port({.ipv4_only = ipv4_only, .streams = true});
    const Peer asked{.address = hal::from_ipv4(127, 0, 0, 5), .port = sensor->port()};
    ASSERT_EQ(send(*robot, asked, "hello"), Status::kOk);
    const Heard heard = receive(*sensor);
    EXPECT_EQ(heard.from.own, asked.address);
    ASSERT_EQ(send(*sensor, heard.from, "answer"), Status::kOk);
    EXPECT_EQ(receive(*robot).from, asked);
    const std::span<const std::byte> frame = std::as_bytes(std::span("frame"));
    std::size_t sent = 0;
    ASSERT_EQ(sensor->stream(2, heard.from, std::span(&frame, 1), sent), Status::kOk);
    EXPECT_EQ(receive(*robot).from, asked);
    // Of an address that this machine has not, or not any more.
    Peer gone = heard.from;
    gone.own = hal::from_ipv4(192, 0, 2, 1);
    EXPECT_EQ(send(*sensor, gone, "answer"), Status::kOk);
    EXPECT_EQ(receive(*robot).text, "answer");
  }
}

// Whoever forges the broadcast address as his own must not have streams sent to a whole network.
TEST(UdpPort, SendsToAllHostsOnlyWhereItWasAskedTo) {
  const Peer all{.address = hal::from_ipv4(127, 255, 255, 255), .port = 9};
  for (const bool ipv4_only : {false, true}) {
    EXPECT_EQ(send(*open_port({.ipv4_only = ipv4_only}), all, "all"), Status::kDeviceError);
    EXPECT_EQ(send(*open_port({.ipv4_only = ipv4_only, .broadcast = true}), all, "all"),
              Status::kOk);
  }
}

// By that interface, whatever the routes say; whoever hears it knows by which it came.
TEST(UdpPort, WhatGoesToAllOfALinkIsToldFromWhatGoesToOne) {
  const unsigned loopback = if_nametoindex("lo");
  ASSERT_NE(loopback, 0U);
  const auto broadcasts = open_port({.ipv4_only = true, .broadcast = true});
  for (const bool ipv4_only : {false, true}) {
    const auto port = open_port({.ipv4_only = ipv4_only});
    const Peer all{.address = hal::kAllOfLink, .port = port->port(), .scope = loopback};
    ASSERT_EQ(send(*broadcasts, all, "all"), Status::kOk);
    ASSERT_EQ(send(*broadcasts, local(port->port()), "one"), Status::kOk);
    for (const unsigned link : {loopback, 0U}) {
      std::array<std::byte, 8> space;
      const Result<hal::Received> received = port->receive(space, 60s);
      ASSERT_TRUE(received);
      EXPECT_EQ(received->link, link);
      EXPECT_EQ(received->from.scope, 0U);
    }
    // Where that interface is none it goes nowhere else.
    const Peer nowhere{.address = hal::kAllOfLink,
                       .port = port->port(),
                       .scope = 1U << 30,
                       .own = hal::from_ipv4(127, 0, 0, 1)};
    EXPECT_EQ(send(*broadcasts, nowhere, "lost"), Status::kDeviceError);
  }
}

TEST(UdpPort, SendsAndReceivesMoreThanABatchInOrder) {
  const auto one = open_port();
  const auto two = open_port();
  constexpr std::size_t kMany = 150;
  std::vector<std::array<std::byte, 1>> bytes(kMany);
  std::vector<std::span<const std::byte>> datagrams;
  for (std::size_t i = 0; i < kMany; ++i) {
    bytes[i][0] = static_cast<std::byte>(i);
    datagrams.emplace_back(bytes[i]);
  }
  std::size_t sent = 0;
  ASSERT_EQ(one->send(local(two->port()), datagrams, sent), Status::kOk);
  EXPECT_EQ(sent, kMany);
  for (std::size_t i = 0; i < kMany; ++i) {
    std::array<std::byte, 8> space;
    const Result<hal::Received> received = two->receive(space, 60s);
    ASSERT_TRUE(received) << i;
    ASSERT_EQ(space[0], static_cast<std::byte>(i));
  }
}

TEST(UdpPort, TellsTheWholeLengthOfWhatIsTooLong) {
  const auto one = open_port();
  const auto two = open_port();
  ASSERT_EQ(send(*one, local(two->port()), std::string(100, 'a')), Status::kOk);
  std::array<std::byte, 10> space{};
  const Result<hal::Received> received = two->receive(space, 60s);
  ASSERT_TRUE(received);
  EXPECT_EQ(received->bytes, 100U);
  EXPECT_EQ(space.back(), std::byte{'a'});
}

TEST(UdpPort, RefusesWhatIsTooLargeAndSendsWhatStandsBeforeIt) {
  const auto one = open_port();
  const auto two = open_port();
  const std::vector<std::byte> fits(hal::kMaxDatagram);
  const std::vector<std::byte> large(hal::kMaxDatagram + 1);
  const std::array<std::span<const std::byte>, 3> three{fits, large, fits};
  std::size_t sent = 0;
  EXPECT_EQ(one->send(local(two->port()), three, sent), Status::kTooLarge);
  EXPECT_EQ(sent, 1U);
}

TEST(UdpPort, ReceiveWaitsNoLongerThanAsked) {
  const auto port = open_port();
  EXPECT_EQ(receive(*port, 0ns).text, "timeout");
  EXPECT_EQ(receive(*port, 20ms).text, "timeout");
  EXPECT_EQ(receive(*port, -1s).text, "timeout");
}

TEST(UdpPort, TellsWhoRefusesAndLosesNothingForIt) {
  if (!tells_refusals()) {
    GTEST_SKIP() << "this system does not tell who refuses";
  }
  const auto sensor = open_port({.refusals = true});
  const auto alive = open_port();
  std::uint16_t closed = 0;
  {
    closed = open_port()->port();
  }
  for (int i = 0; i < 50; ++i) {  // each one's refusal meets the next datagram to somebody else
    ASSERT_EQ(send(*sensor, local(closed), "anybody?"), Status::kOk);
    ASSERT_EQ(send(*sensor, local(alive->port()), "frame"), Status::kOk);
  }
  for (int i = 0; i < 50; ++i) {
    ASSERT_EQ(receive(*alive).text, "frame") << i;
  }
  Peer peer;
  ASSERT_TRUE(hears_refusal(*sensor, peer));
  EXPECT_EQ(peer, local(closed));
  ASSERT_EQ(send(*alive, local(sensor->port()), "still there"), Status::kOk);
  EXPECT_EQ(receive(*sensor).text, "still there");
}

TEST(UdpPort, TellsWhoRefusesOnIpv6) {
  if (!tells_refusals()) {
    GTEST_SKIP() << "this system does not tell who refuses";
  }
  const auto sensor = open_port({.refusals = true});
  std::uint16_t closed = 0;
  {
    closed = open_port()->port();
  }
  if (send(*sensor, local6(closed), "anybody?") != Status::kOk) {
    GTEST_SKIP() << "a machine without IPv6";
  }
  Peer peer;
  ASSERT_TRUE(hears_refusal(*sensor, peer));
  EXPECT_EQ(peer, local6(closed));
}

TEST(UdpPort, CountsWhatFoundItsBufferFull) {
  if (!counts_overruns()) {
    GTEST_SKIP() << "this system does not count datagrams that find the buffer full";
  }
  const auto one = open_port();
  const auto two = open_port({.buffer_bytes = 4096});
  constexpr std::uint64_t kSent = 200;
  for (std::uint64_t i = 0; i < kSent; ++i) {
    ASSERT_EQ(send(*one, local(two->port()), std::string(500, 'x')), Status::kOk);
  }
  std::uint64_t heard = 0;
  while (receive(*two, 0ns).text != "timeout") {
    ++heard;
  }
  ASSERT_EQ(send(*one, local(two->port()), "carries the count"), Status::kOk);
  ASSERT_EQ(receive(*two).text, "carries the count");
  EXPECT_LT(heard, kSent);
  EXPECT_EQ(heard + two->overruns(), kSent);
}

TEST(UdpPort, SendsFromTwoThreadsAtOnce) {
  const auto one = open_port();
  const auto two = open_port();
  const auto send_many = [&](char which) {
    for (int i = 0; i < 100; ++i) {
      ASSERT_EQ(send(*one, local(two->port()), std::string(1, which)), Status::kOk);
    }
  };
  std::thread other(send_many, 'b');
  send_many('a');
  other.join();
  int a = 0;
  int b = 0;
  for (Heard heard = receive(*two, 0ns); heard.text.size() == 1; heard = receive(*two, 0ns)) {
    a += heard.text == "a" ? 1 : 0;
    b += heard.text == "b" ? 1 : 0;
  }
  EXPECT_EQ(a, 100);
  EXPECT_EQ(b, 100);
}

TEST(UdpPort, SaysInOneLineThatAPortIsTaken) {
  const auto first = open_port();
  const auto second = UdpPort::open({.port = first->port()});
  ASSERT_FALSE(second);
  const std::string& message = second.error().message;
  EXPECT_NE(message.find(std::to_string(first->port())), std::string::npos) << message;
  EXPECT_EQ(std::ranges::count(message, '\n'), 0);
}

TEST(UdpPort, IsGrantedBuffersThatHoldAFrame) {
  const auto port = open_port();
  EXPECT_GT(port->send_buffer(), 0);
  EXPECT_GT(port->receive_buffer(), 0);
}

TEST(Resolve, FindsAddresses) {
  EXPECT_EQ(resolve("127.0.0.1:5600"), local(5600));
  EXPECT_EQ(resolve("[::1]:5600"), local6(5600));
}

TEST(Resolve, FindsNames) {
  if (!knows_localhost()) {
    GTEST_SKIP() << kNoLocalhost;
  }
  const auto named = resolve("localhost:1");
  ASSERT_TRUE(named) << named.error().message;
  EXPECT_TRUE(*named == local(1) || *named == local6(1));
}

TEST(Resolve, RefusesBadDestinationsInOneLine) {
  for (const std::string bad :
       {"", "127.0.0.1", ":5600", "127.0.0.1:", "127.0.0.1:0", "127.0.0.1:65536", "127.0.0.1:56x",
        "127.0.0.1:-1", "::1:5600", "[]:5600", "a..b:5600"}) {
    const auto peer = resolve(bad);
    ASSERT_FALSE(peer) << bad;
    const std::string& message = peer.error().message;
    EXPECT_NE(message.find("'" + bad + "'"), std::string::npos) << message;
    EXPECT_EQ(std::ranges::count(message, '\n'), 0);
  }
}

}  // namespace
}  // namespace stof::test
