#include "hal/emu/devices/serial_port.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <span>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "hal/linux/ports/serial_tty.h"
#include "tests/support/pty.h"

namespace stof::test {
namespace {

using hal::emu::FaultKind;
using hal::linux::SerialTty;

std::span<const std::byte> bytes(const std::string& text) { return std::as_bytes(std::span(text)); }

TEST(SerialTty, CarriesEveryByteBothWays) {
  Pty pty;
  if (!pty.open() && !pty.has_any_speed()) {
    GTEST_SKIP() << "this system makes no pseudo-terminals";
  }
  ASSERT_FALSE(pty.name().empty());
  auto tty = SerialTty::open({.device = pty.name(), .baud = 921'600});
  ASSERT_TRUE(tty) << tty.error();
  std::string all;
  for (int value = 0; value < 256; ++value) {
    all.push_back(static_cast<char>(value));  // also what terminals interpret
  }
  ASSERT_EQ(tty->write(bytes(all)), all.size());
  EXPECT_EQ(pty.read(all.size()), all);
  pty.write(all);
  std::string got;
  std::array<std::byte, 100> space{};
  for (int tries = 0; got.size() < all.size() && tries < 60'000; ++tries) {
    const Result<std::size_t> count = tty->read(space);
    ASSERT_TRUE(count);
    for (std::size_t i = 0; i < *count; ++i) {
      got.push_back(static_cast<char>(space[i]));
    }
    if (*count == 0) {  // the system carries it when it comes to it
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  EXPECT_EQ(got, all);
}

TEST(SerialTty, NeitherWaitsToReadNorToWrite) {
  Pty pty;
  if (!pty.open() && !pty.has_any_speed()) {
    GTEST_SKIP() << "this system makes no pseudo-terminals";
  }
  ASSERT_FALSE(pty.name().empty());
  auto tty = SerialTty::open({.device = pty.name(), .baud = 115'200});
  ASSERT_TRUE(tty) << tty.error();
  std::array<std::byte, 16> space{};
  EXPECT_EQ(tty->read(space), 0U);
  EXPECT_EQ(tty->read({}), 0U);
  EXPECT_EQ(tty->write({}), 0U);
  const std::string block(4096, 'x');
  bool full = false;
  for (int i = 0; i < 10'000 && !full; ++i) {  // nobody reads: the queue fills up
    const Result<std::size_t> count = tty->write(bytes(block));
    ASSERT_TRUE(count);
    full = *count == 0;
  }
  EXPECT_TRUE(full);
}

TEST(SerialTty, MakesAnySpeedOfItsRange) {
  Pty pty;
  if (!pty.open() && !pty.has_any_speed()) {
    GTEST_SKIP() << "this system makes no pseudo-terminals";
  }
  ASSERT_FALSE(pty.name().empty());
  auto tty = SerialTty::open({.device = pty.name(), .baud = 57'600});
  ASSERT_TRUE(tty) << tty.error();
  for (const std::uint32_t baud : {921'600U, 3'000'000U}) {
    EXPECT_EQ(tty->set_baud(baud), Status::kOk) << baud;
  }
  for (const std::uint32_t baud : {57'601U, 1'234'567U, 12'000'000U}) {
    EXPECT_EQ(tty->set_baud(baud), pty.has_any_speed() ? Status::kOk : Status::kUnsupported)
        << baud;
  }
  for (const std::uint32_t baud : {0U, 9600U, 57'599U, 12'000'001U}) {
    EXPECT_EQ(tty->set_baud(baud), Status::kUnsupported) << baud;
  }
  EXPECT_EQ(tty->write(bytes("still there")), 11U);
  EXPECT_EQ(pty.read(11), "still there");
}

TEST(SerialTty, FlowControlStaysAsItWasAskedFor) {
  for (const bool asked : {false, true}) {
    Pty pty;
    if (!pty.open() && !pty.has_any_speed()) {
      GTEST_SKIP() << "this system makes no pseudo-terminals";
    }
    auto tty = SerialTty::open({.device = pty.name(), .baud = 921'600, .flow_control = asked});
    ASSERT_TRUE(tty) << tty.error();
    EXPECT_EQ(pty.has_flow_control(), asked);
    EXPECT_EQ(tty->set_baud(115'200), Status::kOk);
    EXPECT_EQ(pty.has_flow_control(), asked);
    EXPECT_EQ(tty->reopen(), Status::kOk);
    EXPECT_EQ(pty.has_flow_control(), asked);
  }
}

TEST(SerialTty, TellsWhenTheOtherEndIsGoneAndComesBack) {
  Pty pty;
  if (!pty.open() && !pty.has_any_speed()) {
    GTEST_SKIP() << "this system makes no pseudo-terminals";
  }
  ASSERT_FALSE(pty.name().empty());
  auto tty = SerialTty::open({.device = pty.name()});
  ASSERT_TRUE(tty) << tty.error();
  pty.close();
  std::array<std::byte, 16> space{};
  EXPECT_EQ(tty->read(space), fail(Status::kDeviceLost));
  EXPECT_EQ(tty->write(bytes("x")), fail(Status::kDeviceLost));
  EXPECT_EQ(tty->reopen(), Status::kDeviceLost);
  EXPECT_EQ(tty->write(bytes("x")), fail(Status::kDeviceLost));
  EXPECT_EQ(tty->set_baud(921'600), Status::kDeviceLost);
}

TEST(SerialTty, ReopensInPlaceAndSurvivesBeingMoved) {
  Pty pty;
  if (!pty.open() && !pty.has_any_speed()) {
    GTEST_SKIP() << "this system makes no pseudo-terminals";
  }
  ASSERT_FALSE(pty.name().empty());
  auto first = SerialTty::open({.device = pty.name()});
  ASSERT_TRUE(first) << first.error();
  SerialTty tty(std::move(*first));
  EXPECT_EQ(tty.reopen(), Status::kOk);
  EXPECT_EQ(tty.write(bytes("again")), 5U);
  EXPECT_EQ(pty.read(5), "again");
}

TEST(SerialTty, RefusesInOneLineWhatIsNoSerialLine) {
  struct Case {
    std::string device;
    std::uint32_t baud;
    std::string hint;
  };
  for (const Case& bad : {Case{"/nonexistent/tty", 921'600, "check the cable"},
                          Case{"/dev/null", 921'600, "give the name of a serial line"},
                          Case{"/dev/ttyAMA0", 9600, "give 57600 to 12000000 baud"}}) {
    const auto tty = SerialTty::open({.device = bad.device, .baud = bad.baud});
    ASSERT_FALSE(tty) << bad.device;
    EXPECT_NE(tty.error().find("'" + bad.device + "'"), std::string::npos) << tty.error();
    EXPECT_NE(tty.error().find(bad.hint), std::string::npos) << tty.error();
    EXPECT_EQ(std::ranges::count(tty.error(), '\n'), 0);
  }
}

std::string take(hal::emu::SerialPort& port) {
  std::array<std::byte, 64> space{};
  const std::size_t count = port.take(space);
  std::string text;
  for (std::size_t i = 0; i < count; ++i) {
    text.push_back(static_cast<char>(space[i]));
  }
  return text;
}

std::string sent_with(FaultKind kind) {
  hal::emu::SerialPort port(64, 921'600, {{.kind = kind, .call = 1}});
  std::size_t at = 0;
  const std::string text = "abcdefgh";
  for (int i = 0; i < 8 && at < text.size(); ++i) {
    const auto count = port.write(bytes(text).subspan(at, std::min<std::size_t>(4, 8 - at)));
    if (!count) {
      EXPECT_EQ(port.write(bytes("zzzz")), fail(Status::kDeviceLost));
      EXPECT_EQ(port.reopen(), Status::kOk);
      continue;
    }
    at += *count;
  }
  return take(port);
}

TEST(EmulatedSerialPort, StrikesAsItsPlanSays) {
  EXPECT_EQ(sent_with(FaultKind::kNone), "abcdefgh");
  EXPECT_EQ(sent_with(FaultKind::kDrop), "abcd");
  EXPECT_EQ(sent_with(FaultKind::kDelay), "abcdefgh");
  EXPECT_EQ(sent_with(FaultKind::kTear), "abcdefgh");
  EXPECT_EQ(sent_with(FaultKind::kRepeat), "abcdefghh");
  EXPECT_EQ(sent_with(FaultKind::kCorrupt),
            std::string("abcdef") + static_cast<char>('g' ^ 0xFF) + "h");
  EXPECT_EQ(sent_with(FaultKind::kVanish), "abcdefgh");
}

TEST(EmulatedSerialPort, TakesNoMoreThanItHolds) {
  hal::emu::SerialPort port(4, 921'600);
  EXPECT_EQ(port.write(bytes("abcdef")), 4U);
  EXPECT_EQ(port.write(bytes("ef")), 0U);
  EXPECT_EQ(take(port), "abcd");
  port.feed(bytes("123456"));
  std::array<std::byte, 16> space{};
  EXPECT_EQ(port.read(space), 4U);
  EXPECT_EQ(port.set_baud(0), Status::kUnsupported);
  EXPECT_EQ(port.set_baud(57'600), Status::kOk);
  EXPECT_EQ(port.baud(), 57'600U);
}

}  // namespace
}  // namespace stof::test
