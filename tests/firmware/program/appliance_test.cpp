#include "firmware/program/appliance.h"

#include <gtest/gtest.h>

#include "posix/worker_threads.h"
#include "tests/firmware/appliance_rig.h"

namespace stof::firmware::test {
namespace {

TEST(Appliance, SendsNothingUntilSomebodySubscribes) {
  ApplianceRig box;
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
  ApplianceRig box;
  box.subscribe(1);
  box.run(5);
  RunConfig run_config = small_run_config();
  run_config.publisher.revision = 2;
  run_config.publisher.choice.of(wire::Stream::kSource) = wire::Coding::kOff;
  ASSERT_TRUE(box.run_configs.push(run_config));
  const Receiver without = box.run(5);
  EXPECT_EQ(without.frames.size(), 5U);
  for (const auto& [number, frame] : without.frames) {
    EXPECT_TRUE(frame.complete());
    EXPECT_EQ(frame.info.tiles[2], 0);
    EXPECT_EQ(frame.info.settings_revision, 2U);
  }
}

TEST(Appliance, AnotherWayToComputeDepthCostsNoMoreThanAFrame) {
  ApplianceRig box;
  box.subscribe(1);
  box.run(5);
  RunConfig run_config = small_run_config();
  run_config.setup.depth.match = dsp::for_depth(*dsp::find_preset("quality"));
  run_config.setup.depth.match.disparities = kDisparities;
  run_config.publisher.revision = 3;
  ASSERT_TRUE(box.run_configs.push(run_config));
  const Receiver after = box.run(10);
  EXPECT_GE(after.frames.size(), 9U);
  EXPECT_EQ(after.frames.rbegin()->second.info.settings_revision, 3U);
  EXPECT_EQ(box.rig.events.counters.skipped_periods, 0U);
  EXPECT_EQ(box.rig.events.counters.unpaired_edges, 0U);
}

// Every datagram of `run_configs`, each for some frames.
std::vector<std::byte> sent_with(dsp::ThreadTeam threads, std::span<const RunConfig> run_configs) {
  ApplianceRig box(false, threads);
  box.subscribe(1);
  std::vector<std::byte> bytes = box.run(5).bytes;
  for (const RunConfig& run_config : run_configs) {
    EXPECT_TRUE(box.run_configs.push(run_config));
    const Receiver some = box.run(5);
    EXPECT_GE(some.frames.size(), 4U);
    bytes.insert(bytes.end(), some.bytes.begin(), some.bytes.end());
  }
  return bytes;
}

TEST(Appliance, AnyNumberOfThreadsSendsTheSameBytes) {
  posix::WorkerThreads workers({.threads = 4});
  std::vector<RunConfig> run_configs;
  for (const char* const preset : {"", "quality", "fast"}) {
    for (const int threads : {3, 1, 4, 2, 7}) {  // more than there are, too
      RunConfig& run_config = run_configs.emplace_back(small_run_config());
      run_config.setup.threads = threads;
      if (*preset != '\0') {
        run_config.setup.depth.match = dsp::for_depth(*dsp::find_preset(preset));
        run_config.setup.depth.match.disparities = kDisparities;
      }
    }
  }
  const std::vector<std::byte> alone = sent_with({}, run_configs);
  EXPECT_GT(alone.size(), run_configs.size() * 4 * kWidth * kHeight);
  EXPECT_TRUE(sent_with({workers, 4}, run_configs) == alone);
}

TEST(Appliance, OtherThreadsWhileItRunsShowNoOldFrame) {
  posix::WorkerThreads workers({.threads = 4});
  ApplianceRig box(false, {workers, 4});
  box.subscribe(1);
  Receiver receiver = box.run(5);
  for (const int threads : {4, 1, 3, 2}) {
    RunConfig run_config = small_run_config();
    run_config.setup.threads = threads;
    run_config.publisher.revision = static_cast<std::uint32_t>(threads);
    ASSERT_TRUE(box.run_configs.push(run_config));
    receiver.frames.merge(box.run(5).frames);
    EXPECT_EQ(receiver.frames.rbegin()->second.info.settings_revision,
              run_config.publisher.revision);
  }
  EXPECT_GE(receiver.frames.size(), 21U);  // at most one is lost each time
  EXPECT_EQ(expect_true_frames(box.rig, receiver).size(), receiver.frames.size());
  EXPECT_EQ(box.rig.events.counters.skipped_periods, 0U);
}

TEST(Appliance, AnotherPeriodBeginsAnewWithoutASkip) {
  ApplianceRig box;
  box.subscribe(1);
  box.run(5);
  RunConfig run_config = small_run_config();
  run_config.timing.period = 50ms;
  ASSERT_TRUE(box.run_configs.push(run_config));
  const std::size_t before = box.rig.log.edges.size();
  const Receiver after = box.run(10);
  EXPECT_GE(after.frames.size(), 9U);
  for (std::size_t i = before + 1; i < box.rig.log.edges.size(); ++i) {
    EXPECT_EQ(box.rig.log.edges[i] - box.rig.log.edges[i - 1], 50ms);
  }
  EXPECT_EQ(box.rig.events.counters.skipped_periods, 0U);
}

TEST(Appliance, ADestinationThatIsSilentIsToldAndSentToNevertheless) {
  ApplianceRig box;
  ReceiverList list;
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
  ApplianceRig box(true);
  RunConfig run_config = small_run_config();
  run_config.serial.mode = settings::SerialMode::kStof;
  run_config.serial.profile = settings::SerialProfile::kCoarse;
  ASSERT_TRUE(box.run_configs.push(run_config));
  box.run(40);
  EXPECT_GT(box.serial.waiting(), 100U);
  EXPECT_GT(box.appliance.serial().sent, 5U);
}

}  // namespace
}  // namespace stof::firmware::test
