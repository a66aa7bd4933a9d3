#include "firmware/events/health_monitor.h"

#include <chrono>
#include <utility>
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

// What is active changes with an event alone, so that nobody says anything else of it unnoticed.
TEST(HealthMonitor, HealthNamesTheEventThatMadeItSo) {
  HealthMonitor monitor(at(0s));
  const auto health = [&](hal::Duration now) {
    return monitor.next_health({}, {}, true, at(now)).value();
  };
  const std::uint32_t none = health(0s).events;
  EXPECT_EQ(none, 1U);
  EXPECT_EQ(health(1s).events, none);
  for (const auto& [kind, camera] : {std::pair(EventKind::kLost, Component::kPmd),
                                     std::pair(EventKind::kLost, Component::kTrigger),
                                     std::pair(EventKind::kBack, Component::kPmd)}) {
    monitor.observe(happened(kind, camera, 2s));
    const wire::HealthReport told = health(2s);
    const auto sent = events(monitor, 2s);
    ASSERT_EQ(sent.size(), 1U);
    EXPECT_EQ(told.events, sent[0].sequence);
    EXPECT_EQ((told.active >> sent[0].condition) & 1U, sent[0].active);
  }
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

TEST(HealthMonitor, AChangedCalibrationNamesBothAndLastsForTenSeconds) {
  HealthMonitor monitor{hal::Time{}};
  const auto change = [&](std::uint32_t value, std::uint32_t former) {
    monitor.observe({.at = hal::Time(1s),
                     .kind = EventKind::kCalibrationChanged,
                     .value = value,
                     .former = former});
  };
  change(7, 5);
  change(9, 7);  // before the first was told
  for (const auto& [value, former] : {std::pair{7U, 5U}, std::pair{9U, 7U}}) {
    const auto event = monitor.next_event(hal::Time(1s));
    ASSERT_TRUE(event);
    EXPECT_EQ(event->condition, static_cast<std::uint8_t>(Condition::kCalibrationChanged));
    EXPECT_EQ(event->value, value);
    EXPECT_EQ(event->former, former);
  }
}

TEST(HealthMonitor, AReleaseIsOnTrialUntilItIsConfirmedOrLeft) {
  for (const std::uint32_t outcome : {kReleaseConfirmed, kReleaseLeft}) {
    HealthMonitor monitor(at(0s));
    const auto told = [&](std::uint32_t value, hal::Duration when) {
      monitor.observe(
          {.at = at(when), .kind = EventKind::kRelease, .value = value, .former = 0xAB});
      const auto all = events(monitor, when);
      EXPECT_EQ(all.size(), 1U);
      return all.empty() ? wire::EventReport{} : all.front();
    };
    const wire::EventReport began = told(kReleaseOnTrial, 1s);
    EXPECT_EQ(began.condition, static_cast<std::uint8_t>(Condition::kReleaseOnTrial));
    EXPECT_EQ(began.active, 1);
    EXPECT_EQ(began.former, 0xAB);
    EXPECT_EQ(monitor.summary(), wire::Health::kOk);
    EXPECT_EQ(monitor.next_health({}, {}, true, at(1s))->active, 1U << 31U);
    const wire::EventReport ended = told(outcome, 30s);
    EXPECT_EQ(ended.active, 0);
    EXPECT_EQ(ended.value, outcome);
    EXPECT_EQ(ended.former, 0xAB);
    EXPECT_EQ(monitor.next_health({}, {}, true, at(30s))->active, 0U);
  }
}

TEST(HealthMonitor, WhoComesLaterHearsWhatCameOfATrial) {
  HealthMonitor monitor(at(0s));
  monitor.tell_release_again();
  EXPECT_TRUE(events(monitor, 1s).empty());  // there was none
  monitor.observe(
      {.at = at(2s), .kind = EventKind::kRelease, .value = kReleaseLeft, .former = 0xAB});
  const auto first = events(monitor, 2s);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].active, 0);
  EXPECT_EQ(events(monitor, 3s).size(), 1U);  // the usual repetition
  EXPECT_TRUE(events(monitor, 60s).empty());
  monitor.tell_release_again();
  const auto again = events(monitor, 61s);
  ASSERT_EQ(again.size(), 1U);
  EXPECT_EQ(again[0].sequence, first[0].sequence);
  EXPECT_EQ(again[0].value, kReleaseLeft);
  EXPECT_TRUE(events(monitor, 62s).empty());
}

TEST(HealthMonitor, EachChangeOfTheSettingsIsAnEventAndEndsAfterTenSeconds) {
  HealthMonitor monitor(at(0s));
  const auto events = [&](hal::Time now) {
    std::vector<wire::EventReport> all;
    static_cast<void>(monitor.next_health({}, {}, false, now));
    while (const auto event = monitor.next_event(now)) {
      all.push_back(*event);
    }
    return all;
  };
  monitor.observe(happened(EventKind::kSettingsChanged, Component::kLoop, 1s, 0xC0A80107));
  const auto first = events(at(1s));
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].condition, static_cast<std::uint8_t>(Condition::kSettingsChanged));
  EXPECT_EQ(first[0].value, 0xC0A80107U);
  EXPECT_EQ(first[0].former, kNotOfNetwork);
  monitor.observe(
      {.at = at(5s), .kind = EventKind::kSettingsChanged, .value = 7, .former = kNetworkTakenBack});
  const auto second = events(at(5s));
  ASSERT_EQ(second.size(), 1U);
  EXPECT_EQ(second[0].count, 2U);
  EXPECT_EQ(second[0].value, 7U);
  EXPECT_EQ(second[0].former, kNetworkTakenBack);
  EXPECT_GT(second[0].sequence, first[0].sequence);
  EXPECT_EQ(monitor.summary(), wire::Health::kOk) << "a change is no fault";
  EXPECT_EQ(events(at(6s)).size(), 1U) << "once more";
  EXPECT_TRUE(events(at(14999ms)).empty());
  const auto end = events(at(15s));
  ASSERT_EQ(end.size(), 1U);
  EXPECT_EQ(end[0].active, 0);
}

// What a robot has to know: frames come, and nothing is in them.
TEST(HealthMonitor, BlindnessIsAConditionWhateverBlinds) {
  HealthMonitor monitor(at(0s));
  hal::Time now = at(0s);
  const auto value = [&]() -> std::uint32_t {
    std::uint32_t told = 0;
    now += 1s;
    const auto health = monitor.next_health({}, {}, true, now);
    while (const auto event = monitor.next_event(now)) {
      told = event->condition == static_cast<std::uint8_t>(Condition::kNoDepth) && event->active
                 ? event->value
                 : told;
    }
    const bool active = (health->active >> static_cast<unsigned>(Condition::kNoDepth) & 1U) != 0;
    EXPECT_EQ(active, monitor.summary() == wire::Health::kFault);
    EXPECT_EQ(active, health->reaction == wire::Reaction::kStop);
    return active ? told : 0;
  };
  monitor.note_coverage(10'000, 200);
  EXPECT_EQ(value(), 0U);
  EXPECT_EQ(value(), 0U) << "no frames are another condition";
  monitor.note_coverage(10'000, 199);
  EXPECT_EQ(value(), HealthMonitor::kNoCoverage);
  monitor.note_coverage(10'000, 399);
  static_cast<void>(value());
  EXPECT_EQ(monitor.summary(), wire::Health::kFault) << "it takes twice as much to end it";
  monitor.note_blinding(HealthMonitor::kNoDepthStream, now);
  EXPECT_EQ(value(), HealthMonitor::kNoCoverage | HealthMonitor::kNoDepthStream);
  monitor.note_coverage(10'000, 400);
  EXPECT_EQ(value(), HealthMonitor::kNoDepthStream);
  monitor.note_blinding(HealthMonitor::kShortRange, now);
  EXPECT_EQ(value(), HealthMonitor::kShortRange);
  monitor.note_blinding(0, now);
  EXPECT_EQ(value(), 0U);
}

// Settings, darkness or a cap on the lenses: the PMD camera alone is left, and frames look whole.
TEST(HealthMonitor, APairThatMatchesHardlyAnythingIsACondition) {
  HealthMonitor monitor(at(0s));
  hal::Time now = at(0s);
  const auto told = [&] {
    now += 1s;
    const auto health = monitor.next_health({}, {}, true, now);
    const bool active =
        (health->active >> static_cast<unsigned>(Condition::kStereoBlind) & 1U) != 0;
    EXPECT_EQ(monitor.summary(), active ? wire::Health::kDegraded : wire::Health::kOk);
    EXPECT_EQ(health->reaction == wire::Reaction::kSlow, active);
    return active;
  };
  const auto frame = [&](std::uint64_t matched) {
    monitor.note_coverage(10'000, 9'000);
    monitor.note_matches(10'000, matched);
  };
  frame(200);
  EXPECT_FALSE(told());
  frame(199);
  EXPECT_TRUE(told());
  EXPECT_TRUE(told()) << "a second without a frame says nothing";
  frame(399);
  EXPECT_TRUE(told()) << "it takes twice as much to end it";
  frame(400);
  EXPECT_FALSE(told());
  frame(0);
  frame(400);
  EXPECT_FALSE(told()) << "of the whole second";
  frame(0);
  EXPECT_TRUE(told());
  monitor.note_coverage(10'000, 9'000);  // of the PMD camera alone: the loss of the pair is told
  EXPECT_FALSE(told());
}

TEST(HealthMonitor, TellsWhatTheStartCouldNotUse) {
  HealthMonitor monitor(at(0s));
  ControlStatus control{.settings_dropped = 22, .connection_replaced = 1};
  const auto health = monitor.next_health({}, control, false, at(1s));
  ASSERT_TRUE(health);
  EXPECT_EQ(health->active, 1U << static_cast<unsigned>(Condition::kSettingsDropped) |
                                1U << static_cast<unsigned>(Condition::kConnectionReplaced));
  EXPECT_EQ(monitor.next_event(at(1s))->value, 22U);
  EXPECT_EQ(monitor.next_event(at(1s))->value, 1U);
  control.settings_dropped = 0;
  EXPECT_EQ(monitor.next_health({}, control, true, at(2s))->active,
            1U << static_cast<unsigned>(Condition::kConnectionReplaced));
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
