#include "hal/linux/usb/clock_converter.h"

#include <chrono>
#include <limits>

#include <gtest/gtest.h>

#include "hal/linux/gpio/strobe_log.h"
#include "hal/linux/system/clock_offset.h"

namespace stof::test {
namespace {

using namespace std::chrono_literals;
using hal::Duration;
using hal::Time;
using hal::linux::ClockConverter;
using hal::linux::ClockOffset;
using hal::linux::StrobeLog;

constexpr Time kStart{1000s};
constexpr std::uint64_t kTheirs = 5'000'000'000;

TEST(ClockConverter, KnowsNothingBeforeItWasSynchronised) {
  ClockConverter clock;
  EXPECT_FALSE(clock.convert(kTheirs));
  EXPECT_FALSE(clock.uncertainty(kTheirs));
  EXPECT_FALSE(clock.correct_by_event(kStart, kTheirs));
  clock.sync(kStart, kTheirs, kStart - 1ns);
  clock.sync(kStart, kTheirs, kStart + 2s);
  EXPECT_FALSE(clock.convert(kTheirs));
}

TEST(ClockConverter, TakesTheAnswerWithTheShortestWay) {
  ClockConverter clock;
  clock.sync(kStart, kTheirs, kStart + 400us);
  clock.sync(kStart + 1ms, kTheirs + 1'000'000, kStart + 1ms + 20us);
  clock.sync(kStart + 2ms, kTheirs + 2'000'000, kStart + 2ms + 600us);
  EXPECT_EQ(clock.convert(kTheirs + 1'000'000), kStart + 1ms + 10us);
  EXPECT_EQ(clock.uncertainty(kTheirs + 1'000'000), 10us);
  EXPECT_EQ(clock.uncertainty(kTheirs + 1'001'000'000), 110us) << "100 ppm of a second";
}

TEST(ClockConverter, DriftMakesAnOldAnswerWorseThanANewOne) {
  ClockConverter clock;
  clock.sync(kStart, kTheirs, kStart + 20us);
  clock.sync(kStart + 10s, kTheirs + 10'000'500'000, kStart + 10s + 800us);
  EXPECT_EQ(clock.convert(kTheirs + 10'000'500'000), kStart + 10s + 400us);
}

TEST(ClockConverter, BelievesAnAnswerThatTheReckoningCannotExplain) {
  ClockConverter clock;
  clock.sync(kStart, kTheirs, kStart + 20us);
  clock.sync(kStart + 1ms, 17, kStart + 1ms + 100us);
  EXPECT_EQ(clock.convert(17), kStart + 1ms + 50us);
}

TEST(ClockConverter, CountsAcrossTheWrap) {
  ClockConverter clock;
  const std::uint64_t last = std::numeric_limits<std::uint64_t>::max();
  clock.sync(kStart, last - 999, kStart);
  EXPECT_EQ(clock.convert(1000), kStart + 2us);
  EXPECT_EQ(clock.convert(last - 1999), kStart - 1us);
}

TEST(ClockConverter, HostileStampsConvertToNothing) {
  ClockConverter clock;
  clock.sync(kStart, kTheirs, kStart);
  for (const std::uint64_t stamp :
       {std::uint64_t{1} << 63, (std::uint64_t{1} << 63) + kTheirs, std::uint64_t{1} << 62,
        std::numeric_limits<std::uint64_t>::max() - (std::uint64_t{1} << 50)}) {
    EXPECT_FALSE(clock.convert(stamp));
    EXPECT_FALSE(clock.correct_by_event(kStart, stamp));
  }
}

TEST(ClockConverter, FollowsDriftInBoundedSteps) {
  ClockConverter clock;
  clock.sync(kStart, kTheirs, kStart + 10us);
  for (int i = 1; i <= 300; ++i) {  // 150 ppm fast, ten edges a second
    const Time ours = kStart + i * 100ms;
    const std::uint64_t theirs = kTheirs + static_cast<std::uint64_t>(i) * 100'015'000;
    const Duration error = ours - *clock.convert(theirs);
    EXPECT_LE(std::chrono::abs(error), 20us);
    EXPECT_TRUE(clock.correct_by_event(ours, theirs));
  }
}

TEST(ClockConverter, OneWrongEdgeCostsOneStep) {
  ClockConverter clock;
  clock.sync(kStart, kTheirs, kStart);
  EXPECT_TRUE(clock.correct_by_event(kStart + 1s + 2ms, kTheirs + 1'000'000'000));
  EXPECT_EQ(clock.convert(kTheirs + 1'000'000'000), kStart + 1s + ClockConverter::kMostStep);
  EXPECT_GE(*clock.uncertainty(kTheirs + 1'000'000'000), 1980us) << "and it says so";
}

TEST(ClockOffset, ConvertsThereAndBack) {
  for (const clockid_t id : {CLOCK_BOOTTIME, CLOCK_REALTIME}) {
    const ClockOffset offset(id);
    const Duration monotonic = hal::linux::read_clock(CLOCK_MONOTONIC);
    const Duration other = hal::linux::read_clock(id);
    EXPECT_LT(std::chrono::abs(offset.to_monotonic(other) - Time(monotonic)), 50ms);
    EXPECT_EQ(offset.from_monotonic(offset.to_monotonic(other)), other);
    EXPECT_LT(offset.uncertainty(), 50ms);
  }
}

struct FakeTime {
  Duration now{};
  Duration ahead{};
  int calls = 0;
};
FakeTime fake;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables): a function reads it

// Every reading takes a microsecond, each seventh one a millisecond.
Duration fake_reader(clockid_t clock) noexcept {
  fake.now += ++fake.calls % 7 == 0 ? 1ms : 1us;
  return fake.now + (clock == CLOCK_MONOTONIC ? Duration{} : fake.ahead);
}

TEST(ClockOffset, KeepsTheClosestOfSeveralReadings) {
  fake = {.now = 100s, .ahead = 5s};
  const ClockOffset offset(CLOCK_REALTIME, fake_reader);
  EXPECT_EQ(offset.uncertainty(), 1us);
  EXPECT_EQ(offset.to_monotonic(205s), Time(200s));
}

TEST(ClockOffset, TellsAStepFromASlew) {
  fake = {.now = 100s, .ahead = 5s};
  ClockOffset offset(CLOCK_REALTIME, fake_reader);
  fake.now += 10s;
  fake.ahead += 5ms;  // 500 ppm
  EXPECT_TRUE(offset.measure());
  fake.ahead += 3ms;
  EXPECT_FALSE(offset.measure());
  EXPECT_TRUE(offset.measure());
  fake.ahead -= 3600s;
  EXPECT_FALSE(offset.measure());
}

TEST(StrobeLog, RemembersExposuresThatEnded) {
  StrobeLog log;
  EXPECT_FALSE(log.ended_at(kStart));
  for (int i = 0; i < 100; ++i) {
    const std::uint64_t number = 2 * static_cast<std::uint64_t>(i) + 1;
    log.note_rise(kStart + i * 10ms, number);
    log.note_fall(kStart + i * 10ms + 4ms, number + 1);
  }
  const auto last = log.ended_at(kStart + 1h);
  ASSERT_TRUE(last);
  EXPECT_EQ(last->begin, kStart + 990ms);
  EXPECT_EQ(log.ended_at(kStart + 993ms)->begin, kStart + 980ms) << "the last was not over";
  EXPECT_FALSE(log.ended_at(kStart + 100ms)) << "forgotten";
}

TEST(StrobeLog, HalfAnExposureIsNone) {
  StrobeLog log;
  log.note_fall(kStart, 1);
  log.note_rise(kStart + 1ms, 2);
  log.note_fall(kStart + 2ms, 5);  // 3 and 4 were lost
  log.note_rise(kStart + 3ms, 6);
  log.restart();
  log.note_fall(kStart + 4ms, 7);
  log.note_rise(kStart + 6ms, 8);
  log.note_fall(kStart + 5ms, 9);  // before its rise
  EXPECT_FALSE(log.ended_at(kStart + 1h));
}

}  // namespace
}  // namespace stof::test
