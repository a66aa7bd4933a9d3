#include "firmware/events/health_monitor.h"

#include <chrono>
#include <vector>

#include <gtest/gtest.h>

namespace stof::firmware {
namespace {

using namespace std::chrono_literals;
using wire::Condition;

hal::Time at(hal::Duration since) { return hal::Time(since); }

std::vector<wire::EventReport> events(Reporter& reporter, hal::Duration now) {
  std::vector<wire::EventReport> all;
  while (const auto event = reporter.next_event(at(now))) {
    all.push_back(*event);
  }
  return all;
}

Event happened(EventKind kind, Part part, hal::Duration when, std::uint32_t value = 0) {
  return {.at = at(when), .kind = kind, .part = part, .status = Status::kOk, .value = value};
}

TEST(Reporter, TellsEachChangeAtOnceAndOnceMoreASecondLater) {
  Reporter reporter(at(0s));
  EXPECT_TRUE(events(reporter, 0s).empty());
  reporter.observe(happened(EventKind::kLost, Part::kPmd, 1s));
  const auto first = events(reporter, 1s);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].condition, static_cast<std::uint8_t>(Condition::kPmdLost));
  EXPECT_EQ(first[0].severity, wire::Severity::kCritical);
  EXPECT_EQ(first[0].reaction, wire::Reaction::kStop);
  EXPECT_EQ(first[0].active, 1);
  EXPECT_EQ(first[0].count, 1U);
  EXPECT_EQ(first[0].at_ns, 1'000'000'000);
  EXPECT_TRUE(events(reporter, 1900ms).empty());
  const auto again = events(reporter, 2s);
  ASSERT_EQ(again.size(), 1U);
  EXPECT_EQ(again[0].sequence, first[0].sequence);
  EXPECT_TRUE(events(reporter, 10s).empty());

  reporter.observe(happened(EventKind::kBack, Part::kPmd, 11s));
  const auto ended = events(reporter, 11s);
  ASSERT_EQ(ended.size(), 1U);
  EXPECT_EQ(ended[0].active, 0);
  EXPECT_EQ(ended[0].count, 1U);
  EXPECT_GT(ended[0].sequence, first[0].sequence);
}

TEST(Reporter, AConditionThatGoesOnIsNoNews) {
  Reporter reporter(at(0s));
  for (int i = 0; i < 5; ++i) {
    reporter.observe(happened(EventKind::kUnpaired, Part::kStereo, 1s, 3));
  }
  EXPECT_EQ(events(reporter, 1s).size(), 1U);
}

TEST(Reporter, SumsUpWhatIsActive) {
  Reporter reporter(at(0s));
  EXPECT_EQ(reporter.summary(), wire::Health::kOk);
  reporter.observe(happened(EventKind::kLate, Part::kLoop, 1s, 2));
  EXPECT_EQ(reporter.summary(), wire::Health::kDegraded);
  reporter.observe(happened(EventKind::kLost, Part::kTrigger, 1s));
  EXPECT_EQ(reporter.summary(), wire::Health::kFault);
  reporter.observe(happened(EventKind::kBack, Part::kTrigger, 2s));
  reporter.observe(happened(EventKind::kInTime, Part::kLoop, 2s));
  EXPECT_EQ(reporter.summary(), wire::Health::kOk);
  reporter.set(Condition::kRestartNeeded, true, 0, at(3s));
  EXPECT_EQ(reporter.summary(), wire::Health::kOk) << "nothing to worry about";
}

TEST(Reporter, HealthComesOnceASecondAndOnChange) {
  Reporter reporter(at(0s));
  const Counters counters;
  int reports = 0;
  for (int i = 0; i <= 300; ++i) {  // 10 s of frames
    reporter.frame_sent(20ms, false, 0, at(i * 33ms));
    reports += reporter.next_health(counters, {}, false, at(i * 33ms)) ? 1 : 0;
  }
  EXPECT_GE(reports, 10);
  EXPECT_LE(reports, 11);
  EXPECT_NEAR(reporter.rate_mhz(), 30'300, 1000);
  reporter.observe(happened(EventKind::kLost, Part::kStereo, 9901ms));
  const auto health = reporter.next_health(counters, {}, false, at(9902ms));
  ASSERT_TRUE(health);
  EXPECT_EQ(health->active, 1U << static_cast<unsigned>(Condition::kStereoLost));
  EXPECT_EQ(health->severity, wire::Severity::kCritical);
  EXPECT_EQ(health->reaction, wire::Reaction::kStop);
  EXPECT_EQ(health->uptime_ms, 9902U);
  EXPECT_EQ(health->latency_us, 20'000U);
  EXPECT_FALSE(reporter.next_health(counters, {}, false, at(9903ms)));
  EXPECT_TRUE(reporter.next_health(counters, {}, true, at(9904ms))) << "somebody new listens";
}

TEST(Reporter, ASecondOfDropsOrRefusalsIsACondition) {
  Reporter reporter(at(0s));
  Counters counters;
  Surroundings around;
  static_cast<void>(reporter.next_health(counters, around, false, at(1s)));
  EXPECT_EQ(reporter.summary(), wire::Health::kOk);
  counters.packets_dropped = 5;
  around.control.bad_crc = 2000;
  around.serial_dropped = 3;
  const auto health = reporter.next_health(counters, around, false, at(2s));
  ASSERT_TRUE(health);
  for (const Condition condition :
       {Condition::kLinkFull, Condition::kFlooded, Condition::kSerialFull}) {
    EXPECT_TRUE((health->active >> static_cast<unsigned>(condition)) & 1U);
  }
  EXPECT_EQ(health->control.bad_crc, 2000U);
  static_cast<void>(reporter.next_health(counters, around, false, at(3s)));
  EXPECT_EQ(reporter.summary(), wire::Health::kOk) << "it is over";
}

TEST(Reporter, WhoCannotBeReachedIsNoFullLink) {
  Reporter reporter(at(0s));
  Counters counters;
  reporter.observe(happened(EventKind::kSendFailed, Part::kLink, 500ms));
  counters.packets_dropped = 500;
  const auto health = reporter.next_health(counters, {}, false, at(1s));
  ASSERT_TRUE(health);
  EXPECT_EQ(health->active, 1U << static_cast<unsigned>(Condition::kUnreachable));
}

TEST(Reporter, DriftIsTakenFromFrames) {
  Reporter reporter(at(0s));
  reporter.frame_sent(20ms, true, 0b10, at(1s));
  const auto began = events(reporter, 1s);
  ASSERT_EQ(began.size(), 1U);
  EXPECT_EQ(began[0].value, 0b10U);
  EXPECT_EQ(began[0].reaction, wire::Reaction::kWatch);
}

TEST(Conditions, HaveANameATextAndAreKnown) {
  for (std::size_t i = 0; i < wire::kConditions; ++i) {
    const wire::ConditionInfo* const info = wire::info_of(static_cast<Condition>(i));
    ASSERT_NE(info, nullptr);
    EXPECT_GT(std::string(info->text).size(), 10U);
  }
  EXPECT_EQ(wire::info_of(static_cast<Condition>(wire::kConditions)), nullptr);
}

}  // namespace
}  // namespace stof::firmware
