#include <array>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/messages/event.h"
#include "firmware/wire/messages/health.h"
#include "host/client/reassembler.h"
#include "host/client/session/session_tracker.h"
#include "tests/host/client/sent_frame.h"

namespace stof::client {
namespace {

using test::Datagram;
using test::frame_spec;

constexpr Time kStart{};

Datagram health(std::uint64_t uptime_ms, std::uint32_t active = 0, std::uint32_t session = 1) {
  std::array<std::byte, wire::kHealthReportBytes> payload{};
  wire::encode_health_report({.uptime_ms = uptime_ms, .active = active}, payload);
  test::FrameSpec spec = frame_spec(1);
  spec.origin.session_id = session;
  return test::report_datagram(spec, wire::PacketType::kHealth, payload);
}

Datagram event(std::uint32_t sequence, std::uint32_t session = 1) {
  std::array<std::byte, wire::kEventReportBytes> payload{};
  wire::encode_event_report({.sequence = sequence, .condition = 3, .active = 1, .value = sequence},
                            payload);
  test::FrameSpec spec = frame_spec(1);
  spec.origin.session_id = session;
  return test::report_datagram(spec, wire::PacketType::kEvent, payload);
}

std::vector<std::uint32_t> take_events(Reassembler& reassembler) {
  std::vector<std::uint32_t> sequences;
  while (const std::optional<ToldEvent> taken = reassembler.take_event()) {
    EXPECT_EQ(taken->report.value, taken->report.sequence);
    sequences.push_back(taken->report.sequence);
  }
  return sequences;
}

TEST(Health, TheNewestOfTheSessionIsKept) {
  Reassembler reassembler;
  EXPECT_FALSE(reassembler.health());
  reassembler.push(health(2000, 5), kStart);
  reassembler.push(health(1900, 7), kStart);
  ASSERT_TRUE(reassembler.health());
  EXPECT_EQ(reassembler.health()->active, 5U);
  EXPECT_EQ(reassembler.statistics().late, 1U);
  reassembler.push(health(2000, 6), kStart);  // on change, within the same millisecond
  EXPECT_EQ(reassembler.health()->active, 6U);
  EXPECT_EQ(reassembler.statistics().packets_ok, 2U);
  EXPECT_FALSE(reassembler.take());
  EXPECT_FALSE(reassembler.next_expiry());
}

TEST(Health, EndsWithItsSession) {
  Reassembler reassembler;
  reassembler.push(health(9'000'000), kStart);
  const Time again = kStart + SessionTracker::kSilence;
  reassembler.push(event(1, 2), again);
  EXPECT_FALSE(reassembler.health());
  reassembler.push(health(10, 0, 2), again);
  ASSERT_TRUE(reassembler.health());
  EXPECT_EQ(reassembler.health()->uptime_ms, 10U);
}

TEST(Health, EachIsTakenOnceWithItsSessionAndTime) {
  Reassembler reassembler;
  const Time again = kStart + SessionTracker::kSilence;
  reassembler.push(health(1000, 5), kStart);
  reassembler.push(health(2000, 6), kStart + std::chrono::milliseconds(900));
  reassembler.push(health(2000, 6), kStart + std::chrono::milliseconds(920));  // sent again
  reassembler.push(health(1990), kStart + std::chrono::milliseconds(950));     // late: not believed
  reassembler.push(health(10, 7, 2), again + std::chrono::seconds(1));
  std::vector<std::uint32_t> active;
  std::vector<std::uint32_t> sessions;
  std::vector<Time> times;
  while (const std::optional<ToldHealth> taken = reassembler.take_health()) {
    active.push_back(taken->report.active);
    sessions.push_back(taken->from.session_id);
    times.push_back(taken->arrived);
  }
  EXPECT_EQ(active, (std::vector<std::uint32_t>{5, 6, 7}));
  EXPECT_EQ(sessions, (std::vector<std::uint32_t>{1, 1, 2}));
  EXPECT_EQ(times, (std::vector<Time>{kStart, kStart + std::chrono::milliseconds(900),
                                      again + std::chrono::seconds(1)}));
}

TEST(Health, OfThoseThatNobodyTakesTheNewestAreKept) {
  Reassembler reassembler;
  for (std::uint32_t k = 0; k < 20; ++k) {
    reassembler.push(health(1000 + k, k), kStart);
  }
  for (std::uint32_t k = 4; k < 20; ++k) {
    const std::optional<ToldHealth> taken = reassembler.take_health();
    ASSERT_TRUE(taken);
    EXPECT_EQ(taken->report.active, k);
  }
  EXPECT_FALSE(reassembler.take_health());
}

TEST(Event, IsDeliveredOnceHoweverOftenItArrives) {
  Reassembler reassembler;
  for (int i = 0; i < 3; ++i) {
    reassembler.push(event(7), kStart);
    reassembler.push(event(8), kStart);
  }
  EXPECT_EQ(take_events(reassembler), (std::vector<std::uint32_t>{7, 8}));
  EXPECT_EQ(reassembler.statistics().packets_ok, 6U);
  EXPECT_EQ(reassembler.statistics().duplicate, 0U);
}

TEST(Event, OneThatWasOvertakenIsDelivered) {
  Reassembler reassembler;
  for (const std::uint32_t sequence : {9U, 7U, 8U, 7U, 9U}) {
    reassembler.push(event(sequence), kStart);
  }
  EXPECT_EQ(take_events(reassembler), (std::vector<std::uint32_t>{9, 7, 8}));
}

TEST(Event, NumbersWrap) {
  Reassembler reassembler;
  for (const std::uint32_t sequence : {0xFFFFFFFFU, 0U, 0xFFFFFFFEU, 0xFFFFFFFFU, 1U, 0U}) {
    reassembler.push(event(sequence), kStart);
  }
  EXPECT_EQ(take_events(reassembler), (std::vector<std::uint32_t>{0xFFFFFFFF, 0, 0xFFFFFFFE, 1}));
}

TEST(Event, OneFarBehindIsLate) {
  Reassembler reassembler;
  reassembler.push(event(1000), kStart);
  reassembler.push(event(1000 - 63), kStart);
  reassembler.push(event(1000 - 64), kStart);
  EXPECT_EQ(take_events(reassembler), (std::vector<std::uint32_t>{1000, 937}));
  EXPECT_EQ(reassembler.statistics().late, 1U);
  reassembler.push(event(5000), kStart);  // a jump forgets what is out of the window
  reassembler.push(event(5000 - 63), kStart);
  reassembler.push(event(5000), kStart);
  EXPECT_EQ(take_events(reassembler), (std::vector<std::uint32_t>{5000, 4937}));
}

TEST(Event, ThoseNobodyTakesAreDroppedOldestFirstAndCounted) {
  Reassembler reassembler;
  for (std::uint32_t sequence = 1; sequence <= 70; ++sequence) {
    reassembler.push(event(sequence), kStart);
  }
  EXPECT_EQ(reassembler.statistics().events_dropped, 6U);
  const std::vector<std::uint32_t> left = take_events(reassembler);
  ASSERT_EQ(left.size(), 64U);
  EXPECT_EQ(left.front(), 7U);
  EXPECT_EQ(left.back(), 70U);
}

TEST(Event, EndsWithItsSession) {
  Reassembler reassembler;
  reassembler.push(event(1), kStart);
  reassembler.push(event(2), kStart);
  reassembler.push(event(2, 2), kStart + SessionTracker::kSilence);
  EXPECT_EQ(take_events(reassembler), (std::vector<std::uint32_t>{2}));
  EXPECT_EQ(reassembler.statistics().events_dropped, 2U);
}

TEST(Report, AShortOneIsRefused) {
  for (const wire::PacketType type : {wire::PacketType::kHealth, wire::PacketType::kEvent,
                                      wire::PacketType::kParity, wire::PacketType::kCalibration}) {
    Reassembler reassembler;
    reassembler.push(test::report_datagram(frame_spec(1), type, std::array<std::byte, 17>{}),
                     kStart);
    EXPECT_EQ(reassembler.statistics().bad_field, 1U) << static_cast<int>(type);
    EXPECT_EQ(reassembler.statistics().packets(), 1U);
    EXPECT_FALSE(reassembler.next_expiry());
  }
}

}  // namespace
}  // namespace stof::client
