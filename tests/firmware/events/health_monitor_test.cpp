#include "firmware/events/health_monitor.h"

#include <chrono>
#include <vector>

#include <gtest/gtest.h>

namespace stof::firmware {
namespace {

using namespace std::chrono_literals;
using wire::Condition;

hal::Time at(hal::Duration since) { return hal::Time(since); }

std::vector<wire::EventReport> events(HealthMonitor& monitor, hal::Duration now) {
  std::vector<wire::EventReport> all;
  while (const auto event = monitor.next_event(at(now))) {
    all.push_back(*event);
  }
  return all;
}

Event happened(EventKind kind, Component component, hal::Duration when, std::uint32_t value = 0) {
  return {
      .at = at(when), .kind = kind, .component = component, .status = Status::kOk, .value = value};
}

TEST(HealthMonitor, TellsEachChangeAtOnceAndOnceMoreASecondLater) {
  HealthMonitor monitor(at(0s));
  EXPECT_TRUE(events(monitor, 0s).empty());
  monitor.observe(happened(EventKind::kLost, Component::kPmd, 1s));
  const auto first = events(monitor, 1s);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].condition, static_cast<std::uint8_t>(Condition::kPmdLost));
  EXPECT_EQ(first[0].severity, wire::Severity::kMajor);
  EXPECT_EQ(first[0].reaction, wire::Reaction::kSlow);
  EXPECT_EQ(first[0].active, 1);
  EXPECT_EQ(first[0].count, 1U);
  EXPECT_EQ(first[0].at_ns, 1'000'000'000);
  EXPECT_TRUE(events(monitor, 1900ms).empty());
  const auto again = events(monitor, 2s);
  ASSERT_EQ(again.size(), 1U);
  EXPECT_EQ(again[0].sequence, first[0].sequence);
  EXPECT_TRUE(events(monitor, 10s).empty());

  monitor.observe(happened(EventKind::kBack, Component::kPmd, 11s));
  const auto ended = events(monitor, 11s);
  ASSERT_EQ(ended.size(), 1U);
  EXPECT_EQ(ended[0].active, 0);
  EXPECT_EQ(ended[0].count, 1U);
  EXPECT_GT(ended[0].sequence, first[0].sequence);
}

TEST(HealthMonitor, AConditionThatGoesOnIsNoNews) {
  HealthMonitor monitor(at(0s));
  for (int i = 0; i < 5; ++i) {
    monitor.observe(happened(EventKind::kUnpaired, Component::kStereo, 1s, 3));
  }
  EXPECT_EQ(events(monitor, 1s).size(), 1U);
}

TEST(HealthMonitor, SumsUpWhatIsActive) {
  HealthMonitor monitor(at(0s));
  EXPECT_EQ(monitor.summary(), wire::Health::kOk);
  monitor.observe(happened(EventKind::kLate, Component::kLoop, 1s, 2));
  EXPECT_EQ(monitor.summary(), wire::Health::kDegraded);
  monitor.observe(happened(EventKind::kLost, Component::kTrigger, 1s));
  EXPECT_EQ(monitor.summary(), wire::Health::kFault);
  monitor.observe(happened(EventKind::kBack, Component::kTrigger, 2s));
  monitor.observe(happened(EventKind::kInTime, Component::kLoop, 2s));
  EXPECT_EQ(monitor.summary(), wire::Health::kOk);
  monitor.set(Condition::kRestartNeeded, true, 0, at(3s));
  EXPECT_EQ(monitor.summary(), wire::Health::kOk) << "nothing to worry about";
}

TEST(HealthMonitor, HealthComesOnceASecondAndOnChange) {
  HealthMonitor monitor(at(0s));
  const Counters counters;
  int reports = 0;
  for (int i = 0; i <= 300; ++i) {  // 10 s of frames
    monitor.frame_sent(20ms, false, 0, at(i * 33ms));
    reports += monitor.next_health(counters, {}, false, at(i * 33ms)) ? 1 : 0;
  }
  EXPECT_GE(reports, 10);
  EXPECT_LE(reports, 11);
  EXPECT_NEAR(monitor.rate_millihertz(), 30'300, 1000);
  monitor.observe(happened(EventKind::kLost, Component::kStereo, 9901ms));
  const auto health = monitor.next_health(counters, {}, false, at(9902ms));
  ASSERT_TRUE(health);
  EXPECT_EQ(health->active, 1U << static_cast<unsigned>(Condition::kStereoLost));
  EXPECT_EQ(health->severity, wire::Severity::kMajor);
  EXPECT_EQ(health->reaction, wire::Reaction::kSlow);
  EXPECT_EQ(health->uptime_ms, 9902U);
  EXPECT_EQ(health->latency_us, 20'000U);
  EXPECT_FALSE(monitor.next_health(counters, {}, false, at(9903ms)));
  EXPECT_TRUE(monitor.next_health(counters, {}, true, at(9904ms))) << "somebody new listens";
}

TEST(HealthMonitor, ASecondOfDropsOrRefusalsIsACondition) {
  HealthMonitor monitor(at(0s));
  Counters counters;
  ControlStatus control;
  static_cast<void>(monitor.next_health(counters, control, false, at(1s)));
  EXPECT_EQ(monitor.summary(), wire::Health::kOk);
  counters.packets_dropped = 5;
  control.requests.bad_crc = 2000;
  control.serial_dropped = 3;
  const auto health = monitor.next_health(counters, control, false, at(2s));
  ASSERT_TRUE(health);
  for (const Condition condition :
       {Condition::kLinkFull, Condition::kFlooded, Condition::kSerialFull}) {
    EXPECT_TRUE((health->active >> static_cast<unsigned>(condition)) & 1U);
  }
  EXPECT_EQ(health->control.bad_crc, 2000U);
  static_cast<void>(monitor.next_health(counters, control, false, at(3s)));
  EXPECT_EQ(monitor.summary(), wire::Health::kOk) << "it is over";
}

TEST(HealthMonitor, WhoCannotBeReachedIsNoFullLink) {
  HealthMonitor monitor(at(0s));
  Counters counters;
  monitor.observe(happened(EventKind::kSendFailed, Component::kLink, 500ms));
  counters.packets_dropped = 500;
  const auto health = monitor.next_health(counters, {}, false, at(1s));
  ASSERT_TRUE(health);
  EXPECT_EQ(health->active, 1U << static_cast<unsigned>(Condition::kUnreachable));
}

TEST(HealthMonitor, DriftIsTakenFromFrames) {
  HealthMonitor monitor(at(0s));
  monitor.frame_sent(20ms, true, 0b10, at(1s));
  const auto began = events(monitor, 1s);
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
