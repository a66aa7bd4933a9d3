#include "hal/emu/link.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace stof::test {
namespace {

using hal::emu::Fault;
using hal::emu::FaultKind;
using hal::emu::Link;

Status send(hal::Link& link, std::string_view text) {
  return link.send(std::as_bytes(std::span(text)));
}

std::string text(std::span<const std::byte> bytes) {
  std::string out;
  for (const std::byte byte : bytes) {
    out += static_cast<char>(byte);
  }
  return out;
}

// All that waits, joined.
std::vector<std::string> received(Link& link) {
  std::vector<std::string> out;
  while (const auto datagram = link.receive()) {
    out.push_back(text(*datagram));
  }
  return out;
}

using Texts = std::vector<std::string>;

TEST(EmuLink, DeliversInOrderAndWhole) {
  Link link(4);
  EXPECT_EQ(send(link, "one"), Status::kOk);
  EXPECT_EQ(send(link, ""), Status::kOk);
  EXPECT_EQ(send(link, std::string(hal::kMaxDatagram, 'x')), Status::kOk);
  EXPECT_EQ(link.waiting(), 3);
  EXPECT_EQ(received(link), (Texts{"one", "", std::string(hal::kMaxDatagram, 'x')}));
  EXPECT_EQ(link.waiting(), 0);
}

TEST(EmuLink, FullQueueTakesNothingAndGoesOnWhenRead) {
  Link link(2);
  EXPECT_EQ(send(link, "1"), Status::kOk);
  EXPECT_EQ(send(link, "2"), Status::kOk);
  EXPECT_EQ(send(link, "3"), Status::kWouldBlock);
  EXPECT_EQ(text(link.receive().value()), "1");
  EXPECT_EQ(send(link, "4"), Status::kOk);
  EXPECT_EQ(received(link), (Texts{"2", "4"}));
}

TEST(EmuLink, RefusesWhatIsTooLarge) {
  Link link(2);
  EXPECT_EQ(send(link, std::string(hal::kMaxDatagram + 1, 'x')), Status::kTooLarge);
  EXPECT_EQ(link.waiting(), 0);
}

Texts sent_with(const Fault& fault, Status second = Status::kOk) {
  Link link(16, {fault});
  EXPECT_EQ(send(link, "aaaa"), Status::kOk);
  EXPECT_EQ(send(link, "bbbb"), second);
  EXPECT_EQ(send(link, "cccc"), Status::kOk);
  return received(link);
}

TEST(EmuLinkFaults, EachKindDoesWhatItSays) {
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

TEST(EmuLinkFaults, EveryDelayedDatagramArrivesBehindTheNext) {
  Link link(16, {{.kind = FaultKind::kDelay, .call = 0, .calls = 1, .every = 2}});
  for (const char* const datagram : {"0", "1", "2", "3"}) {
    EXPECT_EQ(send(link, datagram), Status::kOk);
  }
  EXPECT_EQ(received(link), (Texts{"1", "0", "3", "2"}));
}

TEST(EmuLinkFaults, EmptyDatagramsSurviveEveryFault) {
  for (const FaultKind kind : hal::emu::kAllFaultKinds) {
    Link link(4, {{.kind = kind, .call = 0}});
    const Status status = send(link, "");
    EXPECT_EQ(status, kind == FaultKind::kVanish ? Status::kDeviceError : Status::kOk);
    received(link);
  }
}

}  // namespace
}  // namespace stof::test
