#include "firmware/loop/loop_conditions.h"

#include <vector>

#include <gtest/gtest.h>

#include "hal/emu/devices/clock.h"

namespace stof::firmware {
namespace {

class LoopConditionsTest : public testing::Test {
 protected:
  std::vector<EventKind> noted() {
    std::vector<EventKind> kinds;
    while (const auto event = events_.take()) {
      kinds.push_back(event->kind);
      last_ = *event;
    }
    return kinds;
  }
  using Kinds = std::vector<EventKind>;

  hal::emu::Clock clock_;
  Events events_;
  HealthMonitor monitor_{clock_.now()};
  LoopConditions conditions_{clock_, events_, monitor_};
  const Counters& counters_ = events_.counters;
  Event last_;
};

TEST_F(LoopConditionsTest, ALossIsOneEventAndEachAnswerIsCounted) {
  for (int i = 0; i < 3; ++i) {
    conditions_.note_device_status(Component::kPmd, Status::kDeviceLost);
  }
  EXPECT_EQ(noted(), Kinds{EventKind::kLost});
  EXPECT_EQ(last_.component, Component::kPmd);
  EXPECT_TRUE(conditions_.lost(Component::kPmd));
  EXPECT_FALSE(conditions_.lost(Component::kStereo));
  EXPECT_EQ(of(counters_.losses, Component::kPmd), 3U);
  EXPECT_EQ(monitor_.summary(), wire::Health::kDegraded) << "the other sensor may go on";
  conditions_.note_device_status(Component::kPmd, Status::kTimeout);
  EXPECT_EQ(noted(), Kinds{EventKind::kBack}) << "it answers, if only that it has nothing";
  EXPECT_FALSE(conditions_.lost(Component::kPmd));
  EXPECT_EQ(monitor_.summary(), wire::Health::kOk);
}

TEST_F(LoopConditionsTest, ErrorsAndTimeoutsAreCountedAndNoNews) {
  conditions_.note_device_status(Component::kStereo, Status::kTimeout);
  conditions_.note_device_status(Component::kStereo, Status::kCorrupt);
  conditions_.note_device_status(Component::kStereo, Status::kDeviceError);
  conditions_.note_device_status(Component::kStereo, Status::kOk);
  EXPECT_TRUE(noted().empty());
  EXPECT_EQ(of(counters_.timeouts, Component::kStereo), 1U);
  EXPECT_EQ(of(counters_.errors, Component::kStereo), 2U);
  EXPECT_EQ(of(counters_.losses, Component::kStereo), 0U);
}

TEST_F(LoopConditionsTest, AFullLinkIsNoErrorAndAnUnreachableReceiverOneEvent) {
  conditions_.note_link_status(Status::kWouldBlock);
  EXPECT_TRUE(noted().empty());
  EXPECT_EQ(of(counters_.errors, Component::kLink), 0U);
  conditions_.note_link_status(Status::kDeviceError);
  conditions_.note_link_status(Status::kDeviceError);
  EXPECT_EQ(noted(), Kinds{EventKind::kSendFailed});
  EXPECT_EQ(of(counters_.errors, Component::kLink), 2U);
  conditions_.note_link_status(Status::kOk);
  EXPECT_EQ(noted(), Kinds{EventKind::kSending});
}

TEST_F(LoopConditionsTest, ThreeEdgesWithoutAFrameAreAConditionFewerAreCounted) {
  conditions_.note_frame(kBothSensors);
  EXPECT_EQ(noted(), Kinds{EventKind::kPublishing});
  conditions_.note_no_frame(Component::kStereo, Status::kTimeout);
  conditions_.note_no_frame(Component::kStereo, Status::kTimeout);
  conditions_.note_frame(kBothSensors);
  EXPECT_TRUE(noted().empty());
  EXPECT_EQ(conditions_.edges_without_frame(), 0U);
  for (int i = 0; i < 5; ++i) {
    conditions_.note_no_frame(Component::kPmd, Status::kCorrupt);
  }
  EXPECT_EQ(noted(), Kinds{EventKind::kUnpaired});
  EXPECT_EQ(last_.component, Component::kPmd);
  EXPECT_EQ(last_.status, Status::kCorrupt);
  EXPECT_EQ(last_.value, 3U);
  EXPECT_EQ(conditions_.edges_without_frame(), 5U);
  conditions_.note_frame(kBothSensors);
  EXPECT_EQ(noted(), Kinds{EventKind::kPublishing});
  EXPECT_EQ(last_.value, 5U);
  EXPECT_EQ(counters_.unpaired_edges, 7U);
}

TEST_F(LoopConditionsTest, ThreeEdgesWithoutACamerasFrameAreAConditionByTheirCause) {
  using Why = Absence::Why;
  const auto note = [&](Why why, int edges) {
    for (int i = 0; i < edges; ++i) {
      conditions_.note_camera(Component::kPmd, {.why = why, .value = 2});
    }
  };
  note(Why::kNone, 1);
  note(Why::kSilent, 2);
  note(Why::kNone, 1);
  EXPECT_TRUE(noted().empty());
  note(Why::kDark, 5);
  EXPECT_EQ(noted(), Kinds{EventKind::kDark});
  EXPECT_EQ(last_.component, Component::kPmd);
  EXPECT_EQ(last_.value, 2U);
  note(Why::kFrozen, 1);
  EXPECT_EQ(noted(), Kinds{EventKind::kFrozen}) << "it goes on, for another cause";
  EXPECT_EQ(monitor_.summary(), wire::Health::kDegraded);
  note(Why::kNone, 2);
  EXPECT_EQ(noted(), Kinds{EventKind::kSupplying});
  EXPECT_EQ(monitor_.summary(), wire::Health::kOk);
}

TEST_F(LoopConditionsTest, TheLossOfACameraIsItsOnlyCondition) {
  conditions_.note_device_status(Component::kStereo, Status::kDeviceLost);
  for (int i = 0; i < 5; ++i) {
    conditions_.note_camera(Component::kStereo, {.why = Absence::Why::kSilent});
  }
  EXPECT_EQ(noted(), Kinds{EventKind::kLost});
  conditions_.note_device_status(Component::kStereo, Status::kOk);
  conditions_.note_camera(Component::kStereo, {});
  EXPECT_EQ(noted(), Kinds{EventKind::kBack});
  EXPECT_EQ(monitor_.summary(), wire::Health::kOk);
}

TEST_F(LoopConditionsTest, OtherSensorsThanBeforeAreNewsOnceThreeFramesStandOnThem) {
  const auto note = [&](Sensors sensors, int frames) {
    for (int i = 0; i < frames; ++i) {
      conditions_.note_frame(sensors);
    }
  };
  note(kBothSensors, 5);
  EXPECT_EQ(noted(), Kinds{EventKind::kPublishing});
  note(kStereoSensor, 2);
  note(kBothSensors, 1);
  note(kStereoSensor, 2);
  EXPECT_TRUE(noted().empty());
  note(kStereoSensor, 5);
  EXPECT_EQ(noted(), Kinds{EventKind::kStandsOn});
  EXPECT_EQ(last_.value, static_cast<std::uint32_t>(kStereoSensor));
  note(kPmdSensor, 3);
  note(kBothSensors, 3);
  EXPECT_EQ(noted(), (Kinds{EventKind::kStandsOn, EventKind::kStandsOn}));
}

TEST_F(LoopConditionsTest, ALateLoopIsOneEventUntil32EdgesWereInTime) {
  const auto note = [&](std::uint64_t skipped, bool noticeable) {
    conditions_.note_lateness({.skipped = skipped, .noticeable = noticeable}, clock_.now());
  };
  note(0, true);
  EXPECT_TRUE(noted().empty());
  EXPECT_EQ(counters_.late_edges, 1U);
  note(2, false);
  EXPECT_EQ(noted(), Kinds{EventKind::kLate});
  EXPECT_EQ(last_.value, 2U);
  for (int i = 0; i < 31; ++i) {
    note(0, false);
  }
  note(1, false);
  EXPECT_TRUE(noted().empty()) << "it still lasts";
  EXPECT_EQ(counters_.skipped_periods, 3U);
  for (int i = 0; i < 32; ++i) {
    note(0, false);
  }
  EXPECT_EQ(noted(), Kinds{EventKind::kInTime});
  note(1, false);
  EXPECT_EQ(noted(), Kinds{EventKind::kLate});
}

TEST_F(LoopConditionsTest, OnePeriodThatIsSkippedAtTheStartIsOnlyCounted) {
  conditions_.note_lateness({.skipped = 1}, clock_.now());
  EXPECT_TRUE(noted().empty());
  EXPECT_EQ(counters_.skipped_periods, 1U);
  conditions_.note_lateness({.skipped = 1}, clock_.now());
  EXPECT_EQ(noted(), Kinds{EventKind::kLate});
}

TEST_F(LoopConditionsTest, MoreThanOneAtTheStartIsToldAndOneLaterToo) {
  conditions_.note_lateness({.skipped = 2}, clock_.now());
  EXPECT_EQ(noted(), Kinds{EventKind::kLate});
  for (int i = 0; i < 32; ++i) {
    conditions_.note_lateness({}, clock_.now());
  }
  EXPECT_EQ(noted(), Kinds{EventKind::kInTime});
  conditions_.note_lateness({.skipped = 1}, clock_.now());
  EXPECT_EQ(noted(), Kinds{EventKind::kLate});
}

}  // namespace
}  // namespace stof::firmware
