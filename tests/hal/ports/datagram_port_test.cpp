#include "hal/emu/devices/datagram_port.h"

#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace stof::test {
namespace {

using hal::Peer;
using hal::emu::DatagramPort;
using hal::emu::Fault;
using hal::emu::FaultKind;

constexpr Peer kOne{.address = {1}, .port = 1000};
constexpr Peer kTwo{.address = {2}, .port = 2000, .scope = 7};

Status send(hal::DatagramPort& port, std::string_view text, const Peer& to = kOne) {
  const std::span<const std::byte> datagram = std::as_bytes(std::span(text));
  std::size_t sent = 0;
  const Status status = port.send(to, std::span(&datagram, 1), sent);
  EXPECT_EQ(sent, status == Status::kOk ? 1U : 0U);
  return status;
}

std::string text(std::span<const std::byte> bytes) {
  std::string out;
  for (const std::byte byte : bytes) {
    out += static_cast<char>(byte);
  }
  return out;
}

using Texts = std::vector<std::string>;

// All that waits.
Texts taken(DatagramPort& port) {
  Texts out;
  while (const auto datagram = port.take_sent()) {
    out.push_back(text(datagram->bytes));
  }
  return out;
}

TEST(EmuDatagramPort, DeliversInOrderAndWhole) {
  DatagramPort port(4);
  EXPECT_EQ(send(port, "one"), Status::kOk);
  EXPECT_EQ(send(port, ""), Status::kOk);
  EXPECT_EQ(send(port, std::string(hal::kMaxDatagram, 'x')), Status::kOk);
  EXPECT_EQ(port.waiting(), 3);
  EXPECT_EQ(taken(port), (Texts{"one", "", std::string(hal::kMaxDatagram, 'x')}));
  EXPECT_EQ(port.waiting(), 0);
}

TEST(EmuDatagramPort, KeepsToWhomEachWent) {
  DatagramPort port(4);
  EXPECT_EQ(send(port, "a", kOne), Status::kOk);
  EXPECT_EQ(send(port, "b", kTwo), Status::kOk);
  EXPECT_EQ(port.take_sent().value().to, kOne);
  EXPECT_EQ(port.take_sent().value().to, kTwo);
  EXPECT_FALSE(port.take_sent());
}

TEST(EmuDatagramPort, StopsAtTheFirstThatIsNotTakenAndSaysHowManyWere) {
  DatagramPort port(3);
  const std::array<std::byte, 4> bytes{};
  const std::array<std::span<const std::byte>, 5> five{bytes, bytes, bytes, bytes, bytes};
  std::size_t sent = 99;
  EXPECT_EQ(port.send(kOne, five, sent), Status::kWouldBlock);
  EXPECT_EQ(sent, 3U);
  EXPECT_EQ(port.send(kOne, {}, sent), Status::kOk);
  EXPECT_EQ(sent, 0U);
  EXPECT_EQ(taken(port).size(), 3U);
  EXPECT_EQ(port.send(kOne, std::span(five).first(3), sent), Status::kOk);
  EXPECT_EQ(sent, 3U);
}

TEST(EmuDatagramPort, RefusesWhatIsTooLarge) {
  DatagramPort port(2);
  EXPECT_EQ(send(port, std::string(hal::kMaxDatagram + 1, 'x')), Status::kTooLarge);
  EXPECT_EQ(port.waiting(), 0);
}

TEST(EmuDatagramPort, ReceivesWhatWasInjected) {
  DatagramPort port(2);
  std::array<std::byte, hal::kMaxDatagram> space;
  EXPECT_EQ(port.receive(space, hal::Duration::zero()).error(), Status::kTimeout);
  const std::string long_text(1500, 'y');
  port.inject(std::as_bytes(std::span(std::string_view("hello"))), kTwo);
  port.inject(std::as_bytes(std::span(long_text)), kOne);
  port.inject({}, kOne);  // does not fit
  EXPECT_EQ(port.overruns(), 1U);
  const Result<hal::Received> first = port.receive(space, hal::Duration::zero());
  ASSERT_TRUE(first);
  EXPECT_EQ(text(std::span(space).first(first->bytes)), "hello");
  EXPECT_EQ(first->from, kTwo);
  const Result<hal::Received> second = port.receive(std::span(space).first(3), {});
  ASSERT_TRUE(second);
  EXPECT_EQ(second->bytes, 1500U);
  EXPECT_EQ(text(std::span(space).first(5)), "yyylo");
}

TEST(EmuDatagramPort, TellsEachRefusalOnce) {
  DatagramPort port(2);
  Peer peer;
  EXPECT_FALSE(port.take_unreachable(peer));
  port.refuse(kTwo);
  ASSERT_TRUE(port.take_unreachable(peer));
  EXPECT_EQ(peer, kTwo);
  EXPECT_FALSE(port.take_unreachable(peer));
}

Texts sent_with(const Fault& fault, Status second = Status::kOk) {
  DatagramPort port(16, {fault});
  EXPECT_EQ(send(port, "aaaa"), Status::kOk);
  EXPECT_EQ(send(port, "bbbb"), second);
  EXPECT_EQ(send(port, "cccc"), Status::kOk);
  return taken(port);
}

TEST(EmuDatagramPortFaults, EachKindDoesWhatItSays) {
  EXPECT_EQ(sent_with({.kind = FaultKind::kDrop, .call = 1}), (Texts{"aaaa", "cccc"}));
  EXPECT_EQ(sent_with({.kind = FaultKind::kDelay, .call = 1}), (Texts{"aaaa", "cccc", "bbbb"}));
  EXPECT_EQ(sent_with({.kind = FaultKind::kRepeat, .call = 1}),
            (Texts{"aaaa", "bbbb", "bbbb", "cccc"}));
  EXPECT_EQ(sent_with({.kind = FaultKind::kTear, .call = 1}), (Texts{"aaaa", "b\x9d", "cccc"}));
  EXPECT_EQ(sent_with({.kind = FaultKind::kCorrupt, .call = 1}), (Texts{"aaaa",
                                                                        "bb\x9d"
                                                                        "b",
                                                                        "cccc"}));
  EXPECT_EQ(sent_with({.kind = FaultKind::kVanish, .call = 1}, Status::kDeviceError),
            (Texts{"aaaa", "cccc"}));
}

TEST(EmuDatagramPortFaults, EveryDelayedDatagramArrivesBehindTheNextAtItsOwnPeer) {
  DatagramPort port(16, {{.kind = FaultKind::kDelay, .call = 0, .calls = 1, .every = 2}});
  for (const char* const datagram : {"0", "1", "2", "3"}) {
    EXPECT_EQ(send(port, datagram, *datagram % 2 == 0 ? kOne : kTwo), Status::kOk);
  }
  EXPECT_EQ(port.take_sent().value().to, kTwo);
  EXPECT_EQ(port.take_sent().value().to, kOne);
  EXPECT_EQ(taken(port), (Texts{"3", "2"}));
}

TEST(EmuDatagramPortFaults, EmptyDatagramsSurviveEveryFault) {
  for (const FaultKind kind : hal::emu::kAllFaultKinds) {
    DatagramPort port(4, {{.kind = kind, .call = 0}});
    const Status status = send(port, "");
    EXPECT_EQ(status, kind == FaultKind::kVanish ? Status::kDeviceError : Status::kOk);
    taken(port);
  }
}

}  // namespace
}  // namespace stof::test
