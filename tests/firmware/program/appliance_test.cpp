#include "firmware/program/appliance.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/events/log_text.h"
#include "firmware/wire/frame/raw_packets.h"
#include "posix/worker_threads.h"
#include "tests/firmware/appliance_rig.h"

namespace stof::firmware::test {
namespace {

std::string text_of(const Event& event) {
  std::array<char, kMostLine> space;
  settings::PagedWriter line(space);
  describe(event, line);
  return std::string(line.text());
}

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

// Exposures of raw pictures whose frame was the first of a pipeline that was built anew.
int begun_anew(ApplianceRig& box, int steps) {
  int count = 0;
  for (int i = 0; i < steps; ++i) {
    static_cast<void>(box.appliance.step({}));
    while (const auto sent = box.rig.port.take_sent()) {
      const auto packet = wire::parse_packet(sent->bytes);
      if (packet && packet->header.type == wire::PacketType::kRawInfo) {
        const auto info = wire::decode_raw_info(packet->payload);
        count += info && (info->state & wire::kRawBegunAnew) != 0 ? 1 : 0;
      }
    }
  }
  return count;
}

TEST(Appliance, WhoAsksForRawPicturesMayHaveItBeginAnewOnceInThreeSeconds) {
  ApplianceRig box;
  ReceiverList plain;
  plain.peers[0] = {.address = {}, .port = 1};
  plain.count = 1;
  ReceiverList raw = plain;
  raw.raw_receiver = 0;
  raw.raw = {.pictures = wire::kRawPictures};
  ReceiverList anew = raw;
  anew.raw.pictures |= wire::kRawAnew;
  const int second = static_cast<int>(1s / timing().period);
  const auto ask = [&](const ReceiverList& list) { ASSERT_TRUE(box.receivers.push(list)); };
  ask(plain);
  begun_anew(box, 20);
  ask(raw);
  EXPECT_EQ(begun_anew(box, 20), 0);
  ask(anew);
  EXPECT_EQ(begun_anew(box, 20), 1);
  ask(plain);
  begun_anew(box, 1);
  ask(anew);
  EXPECT_EQ(begun_anew(box, second), 0) << "it waits";
  EXPECT_EQ(begun_anew(box, 3 * second), 1);
  EXPECT_EQ(begun_anew(box, 4 * second), 0) << "once for each request";
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

// With another baseline what the pair measures is no longer what the PMD camera does. Whoever
// receives gets the new calibration with the first frame that was made with it.
TEST(Appliance, AnotherCalibrationIsInForceWithTheNextFrame) {
  ApplianceRig box(true);
  box.subscribe(1);
  const Receiver before = box.run(8);
  const Received& last = before.frames.rbegin()->second;
  EXPECT_EQ(last.info.calibration_fingerprint, 0U);
  EXPECT_GT(last.count(dsp::Source::kBoth), 100U);

  RunConfig run_config = small_run_config();
  run_config.setup.calibration.stereo.baseline_m *= 1.25;
  run_config.calibration =
      wire::make_calibration_packet(run_config.setup.calibration, 40'000, timing().period.count())
          .value();
  run_config.calibration.fingerprint = 0x1234'5678;
  run_config.installs = 1;
  ASSERT_TRUE(box.run_configs.push(run_config));
  const Receiver after = box.run(4);
  EXPECT_EQ(box.appliance.installs(), 1U);
  ASSERT_GE(after.frames.size(), 3U);
  for (const auto& [number, frame] : after.frames) {
    EXPECT_EQ(frame.info.calibration_fingerprint, 0x1234'5678U);
    EXPECT_LT(frame.count(dsp::Source::kBoth), last.count(dsp::Source::kBoth) / 2);
  }
  EXPECT_EQ(after.calibrations, 1U);
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

RunConfig with_period(hal::Duration period) {
  RunConfig run_config = small_run_config();
  run_config.timing.period = period;
  run_config.publisher.period = period;
  return run_config;
}

TEST(Appliance, HealthComesOnceASecondAtAnyPeriod) {
  ApplianceRig box;
  box.subscribe(1);
  box.run(5);
  ASSERT_TRUE(box.run_configs.push(with_period(60s)));
  Receiver receiver;
  const hal::Time begin = box.rig.clock.now();
  hal::Duration longest{};
  while (box.rig.clock.now() - begin < 200s) {
    const hal::Time before = box.rig.clock.now();
    static_cast<void>(box.appliance.step({}));
    longest = std::max(longest, box.rig.clock.now() - before);
    receiver.drain(box.rig.port);
  }
  EXPECT_GE(receiver.healths.size(), 195U);
  EXPECT_GE(receiver.frames.size(), 3U);
  EXPECT_LE(longest, 100ms) << "so long it does not look whether it shall end";
}

TEST(Appliance, HealthComesOnceASecondAtAnyPeriodWithoutCameras) {
  for (const hal::Duration period : {hal::Duration(1s), hal::Duration(7s)}) {
    Rig rig({.faults = {.stereo = {emu::Fault{.kind = emu::FaultKind::kDrop, .every = 1}},
                        .pmd = {emu::Fault{.kind = emu::FaultKind::kDrop, .every = 1}}},
             .timing = with_period(period).timing});
    hal::Duration longest{};
    for (int i = 0; i < 2000; ++i) {
      const hal::Time before = rig.clock.now();
      if (rig.loop.wait_part()) {
        static_cast<void>(rig.loop.step());
      }
      longest = std::max(longest, rig.clock.now() - before);
    }
    EXPECT_LE(longest, 350ms);
    EXPECT_GT(rig.log.edges.size(), 4U);
  }
}

// Whoever was slowed down to a frame a minute is brought back at once.
TEST(Appliance, NewSettingsAreInForceWithinASecondAtAnyPeriod) {
  ApplianceRig box;
  box.subscribe(1);
  box.run(5);
  ASSERT_TRUE(box.run_configs.push(with_period(60s)));
  box.run(200);  // 4 s into the first minute
  ASSERT_TRUE(box.run_configs.push(with_period(timing().period)));
  const hal::Time repaired = box.rig.clock.now();
  const std::size_t before = box.rig.log.edges.size();
  while (box.rig.log.edges.size() < before + 10 && box.rig.clock.now() < repaired + 120s) {
    box.run(1);
  }
  EXPECT_LE(box.rig.log.edges[before] - repaired, 100ms);
  EXPECT_LE(box.rig.log.edges.back() - repaired, 1s);
  for (std::size_t i = 1; i < box.rig.log.edges.size(); ++i) {
    EXPECT_GE(box.rig.log.edges[i] - box.rig.log.edges[i - 1], timing().period);
  }
}

TEST(Appliance, WhoChangedTheSettingsIsTold) {
  ApplianceRig box;
  box.subscribe(1);
  constexpr std::array<std::array<std::uint8_t, 16>, 3> by{
      {{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 127, 0, 0, 1},
       {0xFD, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xC0, 0xA8, 1, 5},
       {}}};
  Receiver receiver;
  for (int i = 0; i < 60; ++i) {
    for (std::size_t k = 0; k < (i == 20 || i == 40 ? by.size() : 0U); ++k) {  // in one frame
      ASSERT_TRUE(box.changes.push(
          {.kind = EventKind::kSettingsChanged, .value = who(by[k]), .address = by[k]}));
    }
    static_cast<void>(box.appliance.step({}));
    receiver.drain(box.rig.port);
  }
  std::map<std::uint32_t, std::uint32_t> told;
  for (const wire::EventReport& event : receiver.events) {
    if (event.condition == static_cast<std::uint8_t>(wire::Condition::kSettingsChanged)) {
      told[event.count] = event.value;
    }
  }
  EXPECT_EQ(
      told,
      (std::map<std::uint32_t, std::uint32_t>{
          {1, 0x7F000001}, {2, 0xC0A80105}, {3, 0}, {4, 0x7F000001}, {5, 0xC0A80105}, {6, 0}}));
  std::vector<std::string> lines;
  while (const auto event = box.rig.events.take()) {
    if (event->kind == EventKind::kSettingsChanged) {
      lines.push_back(text_of(*event));
    }
  }
  ASSERT_EQ(lines.size(), 6U);
  EXPECT_EQ(lines[0], "settings changed by 127.0.0.1");
  EXPECT_EQ(lines[1], "settings changed by fd00:0:0:0:0:0:c0a8:105");
  EXPECT_EQ(lines[2], "settings changed over the serial line");
}

TEST(Appliance, KeysThatComeAndGoAreTold) {
  ApplianceRig box;
  box.subscribe(1);
  static_cast<void>(box.run(5));
  for (const EventKind kind : {EventKind::kKeyMade, EventKind::kKeyRenewed, EventKind::kKeyEnded,
                               EventKind::kLastKeyEnded}) {
    ASSERT_TRUE(box.changes.push(
        {.kind = kind, .value = 0x1a2b3c4d, .role = wire::Role::kAdmin, .address = {}}));
  }
  std::set<std::uint32_t> told;
  for (const wire::EventReport& event : box.run(20).events) {
    if (event.condition == static_cast<std::uint8_t>(wire::Condition::kKeysChanged)) {
      EXPECT_EQ(event.value, 0x1a2b3c4dU);
      told.insert(event.count);
    }
  }
  EXPECT_EQ(told, (std::set<std::uint32_t>{1, 2, 3, 4}));
  std::string lines;
  while (const auto event = box.rig.events.take()) {
    lines += text_of(*event) + "\n";
  }
  EXPECT_NE(lines.find("key 1a2b3c4d, role admin, made over the serial line\n"), std::string::npos)
      << lines;
  EXPECT_NE(lines.find("renewed over"), std::string::npos) << lines;
  EXPECT_NE(lines.find("ended over the serial line\n"), std::string::npos) << lines;
  EXPECT_NE(lines.find("It was the last"), std::string::npos) << lines;
}

TEST(Appliance, WhatCameOfAReleaseIsToldOnceAndToWhoeverSubscribesLater) {
  ApplianceRig box;
  box.subscribe(1);
  const auto told = [&](int steps, std::uint32_t release) {
    std::vector<wire::EventReport> all;
    for (int i = 0; i < steps; ++i) {
      static_cast<void>(box.appliance.step({.release = release, .release_fingerprint = 0xAB}));
      Receiver receiver;
      receiver.drain(box.rig.port);
      for (const wire::EventReport& event : receiver.events) {
        if (event.condition == static_cast<std::uint8_t>(wire::Condition::kReleaseOnTrial)) {
          all.push_back(event);
        }
      }
    }
    return all;
  };
  const auto first = told(100, kReleaseLeft);
  ASSERT_EQ(first.size(), 2U);  // and once more a second later
  EXPECT_EQ(first[0].active, 0);
  EXPECT_EQ(first[0].value, kReleaseLeft);
  EXPECT_EQ(first[0].former, 0xABU);
  EXPECT_TRUE(told(100, kReleaseLeft).empty());
  box.subscribe(2);
  const auto later = told(100, kReleaseLeft);
  ASSERT_EQ(later.size(), 1U);
  EXPECT_EQ(later[0].sequence, first[0].sequence);
}

TEST(Appliance, FramesCarryTheFingerprintOfTheirSettings) {
  ApplianceRig box;
  box.subscribe(1);
  RunConfig run_config = small_run_config();
  run_config.publisher.fingerprint = 0x12345678;
  ASSERT_TRUE(box.run_configs.push(run_config));
  for (const auto& [number, frame] : box.run(5).frames) {
    EXPECT_EQ(frame.info.settings_fingerprint, 0x12345678U);
  }
}

// Streams off, or nothing in them: a robot that goes by frames alone would drive on.
TEST(Appliance, ABlindSensorSaysSoAndIsNotGood) {
  ApplianceRig box;
  box.subscribe(1);
  const auto no_depth = [](const Receiver& receiver) {
    return !receiver.healths.empty() &&
           (receiver.healths.back().active >> static_cast<unsigned>(wire::Condition::kNoDepth) &
            1U) != 0;
  };
  EXPECT_FALSE(no_depth(box.run(100)));
  RunConfig run_config = small_run_config();
  run_config.setup.depth.fusion.max_range = 4;  // a millimetre
  ASSERT_TRUE(box.run_configs.push(run_config));
  const Receiver blind = box.run(100);
  EXPECT_TRUE(no_depth(blind));
  EXPECT_EQ(blind.frames.rbegin()->second.stamp.health, wire::Health::kFault);
  ASSERT_TRUE(box.run_configs.push(small_run_config()));
  EXPECT_FALSE(no_depth(box.run(100)));
}

// The PMD camera alone is left, and frames look whole.
TEST(Appliance, APairThatMatchesNothingIsTold) {
  ApplianceRig box;
  box.subscribe(1);
  const auto blind = [](const Receiver& receiver) {
    return !receiver.healths.empty() &&
           (receiver.healths.back().active >> static_cast<unsigned>(wire::Condition::kStereoBlind) &
            1U) != 0;
  };
  EXPECT_FALSE(blind(box.run(100)));
  RunConfig run_config = small_run_config();
  run_config.setup.depth.match.speckle_pixels = 1 << 24;
  ASSERT_TRUE(box.run_configs.push(run_config));
  const Receiver pmd_alone = box.run(100);
  EXPECT_TRUE(blind(pmd_alone));
  EXPECT_EQ(pmd_alone.frames.rbegin()->second.stamp.health, wire::Health::kDegraded);
  ASSERT_TRUE(box.run_configs.push(small_run_config()));
  EXPECT_FALSE(blind(box.run(100)));
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
