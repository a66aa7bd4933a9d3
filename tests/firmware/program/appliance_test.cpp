#include "firmware/program/appliance.h"

#include <gtest/gtest.h>

#include "posix/worker_threads.h"
#include "tests/firmware/box.h"

namespace stof::firmware::test {
namespace {

TEST(Appliance, SendsNothingUntilSomebodySubscribes) {
  Box box;
  EXPECT_TRUE(box.run(5).bytes.empty());
  box.subscribe(1);
  const Receiver receiver = box.run(5);
  EXPECT_EQ(receiver.frames.size(), 5U);
  EXPECT_EQ(receiver.calibrations, 1U) << "with the first frame";
  EXPECT_GE(receiver.healths.size(), 1U) << "at once";
  ASSERT_TRUE(box.receivers.push({}));
  EXPECT_TRUE(box.run(5).bytes.empty());
}

TEST(Appliance, NewSettingsTakeEffectBetweenTwoFrames) {
  Box box;
  box.subscribe(1);
  box.run(5);
  Plan plan = small_plan();
  plan.stream.revision = 2;
  plan.stream.choice.of(wire::Stream::kSource) = wire::Coding::kOff;
  ASSERT_TRUE(box.plans.push(plan));
  const Receiver without = box.run(5);
  EXPECT_EQ(without.frames.size(), 5U);
  for (const auto& [number, frame] : without.frames) {
    EXPECT_TRUE(frame.complete());
    EXPECT_EQ(frame.info.tiles[2], 0);
    EXPECT_EQ(frame.info.settings_revision, 2U);
  }
}

TEST(Appliance, AnotherWayToComputeDepthCostsNoMoreThanAFrame) {
  Box box;
  box.subscribe(1);
  box.run(5);
  Plan plan = small_plan();
  plan.setup.depth.match = dsp::for_depth(*dsp::find_preset("quality"));
  plan.setup.depth.match.disparities = kDisparities;
  plan.stream.revision = 3;
  ASSERT_TRUE(box.plans.push(plan));
  const Receiver after = box.run(10);
  EXPECT_GE(after.frames.size(), 9U);
  EXPECT_EQ(after.frames.rbegin()->second.info.settings_revision, 3U);
  EXPECT_EQ(box.rig.events.counters.skipped_periods, 0U);
  EXPECT_EQ(box.rig.events.counters.unpaired_edges, 0U);
}

// Every datagram of `plans`, each for some frames.
std::vector<std::byte> sent_with(dsp::Crew threads, std::span<const Plan> plans) {
  Box box(false, threads);
  box.subscribe(1);
  std::vector<std::byte> bytes = box.run(5).bytes;
  for (const Plan& plan : plans) {
    EXPECT_TRUE(box.plans.push(plan));
    const Receiver some = box.run(5);
    EXPECT_GE(some.frames.size(), 4U);
    bytes.insert(bytes.end(), some.bytes.begin(), some.bytes.end());
  }
  return bytes;
}

TEST(Appliance, AnyNumberOfThreadsSendsTheSameBytes) {
  posix::WorkerThreads workers({.threads = 4});
  std::vector<Plan> plans;
  for (const char* const preset : {"", "quality", "fast"}) {
    for (const int threads : {3, 1, 4, 2, 7}) {  // more than there are, too
      Plan& plan = plans.emplace_back(small_plan());
      plan.setup.threads = threads;
      if (*preset != '\0') {
        plan.setup.depth.match = dsp::for_depth(*dsp::find_preset(preset));
        plan.setup.depth.match.disparities = kDisparities;
      }
    }
  }
  const std::vector<std::byte> alone = sent_with({}, plans);
  EXPECT_GT(alone.size(), plans.size() * 4 * kWidth * kHeight);
  EXPECT_TRUE(sent_with({workers, 4}, plans) == alone);
}

TEST(Appliance, OtherThreadsWhileItRunsShowNoOldFrame) {
  posix::WorkerThreads workers({.threads = 4});
  Box box(false, {workers, 4});
  box.subscribe(1);
  Receiver receiver = box.run(5);
  for (const int threads : {4, 1, 3, 2}) {
    Plan plan = small_plan();
    plan.setup.threads = threads;
    plan.stream.revision = static_cast<std::uint32_t>(threads);
    ASSERT_TRUE(box.plans.push(plan));
    receiver.frames.merge(box.run(5).frames);
    EXPECT_EQ(receiver.frames.rbegin()->second.info.settings_revision, plan.stream.revision);
  }
  EXPECT_GE(receiver.frames.size(), 21U);  // at most one is lost each time
  EXPECT_EQ(expect_true_frames(box.rig, receiver).size(), receiver.frames.size());
  EXPECT_EQ(box.rig.events.counters.skipped_periods, 0U);
}

TEST(Appliance, AnotherPeriodBeginsAnewWithoutASkip) {
  Box box;
  box.subscribe(1);
  box.run(5);
  Plan plan = small_plan();
  plan.timing.period = 50ms;
  ASSERT_TRUE(box.plans.push(plan));
  const std::size_t before = box.rig.log.edges.size();
  const Receiver after = box.run(10);
  EXPECT_GE(after.frames.size(), 9U);
  for (std::size_t i = before + 1; i < box.rig.log.edges.size(); ++i) {
    EXPECT_EQ(box.rig.log.edges[i] - box.rig.log.edges[i - 1], 50ms);
  }
  EXPECT_EQ(box.rig.events.counters.skipped_periods, 0U);
}

TEST(Appliance, ADestinationThatIsSilentIsToldAndSentToNevertheless) {
  Box box;
  SubscriberList list;
  list.peers[0] = {.address = {}, .port = 1};
  list.count = 1;
  list.refused = true;
  ASSERT_TRUE(box.receivers.push(list));
  EXPECT_EQ(box.run(5).frames.size(), 5U);
  bool told = false;
  while (const auto event = box.rig.events.take()) {
    told = told || event->kind == EventKind::kSendFailed;
  }
  EXPECT_TRUE(told);
}

TEST(Appliance, TheSerialLineGetsItsShare) {
  Box box(true);
  Plan plan = small_plan();
  plan.serial.mode = settings::SerialMode::kStof;
  plan.serial.profile = settings::SerialProfile::kCoarse;
  ASSERT_TRUE(box.plans.push(plan));
  box.run(40);
  EXPECT_GT(box.serial.waiting(), 100U);
  EXPECT_GT(box.appliance.serial().sent, 5U);
}

}  // namespace
}  // namespace stof::firmware::test
