#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/firmware/rig.h"

// One sensor of a rig is lost, silent, frozen or dark for ten seconds.
namespace stof::firmware::test {
namespace {

constexpr std::uint32_t kFirst = 40;   // edge of the outage
constexpr std::uint32_t kEdges = 303;  // 10 s
constexpr int kAfter = 70;
constexpr hal::Duration kPeriod = 33ms;

using wire::Condition;

struct Outage {
  std::string name;
  Sensors left;  // that goes on
  Condition condition;
  std::uint32_t value;
  RigOptions options;
};
std::ostream& operator<<(std::ostream& out, const Outage& outage) { return out << outage.name; }

RigOptions with_fault(emu::FaultPlan Faults::* device, emu::FaultKind kind) {
  RigOptions options;
  options.faults.*device = {emu::Fault{.kind = kind, .call = kFirst, .calls = kEdges}};
  return options;
}

RigOptions with_pixels(PixelFault PixelFaults::* sensor, bool dark) {
  RigOptions options;
  options.pixels.*sensor = {.first = kFirst, .edges = kEdges, .dark = dark};
  return options;
}

RigOptions with_frozen_pair() {
  RigOptions options = with_pixels(&PixelFaults::left, false);
  options.pixels.right = options.pixels.left;
  return options;
}

std::vector<Outage> outages() {
  using emu::FaultKind;
  return {
      {"pair unplugged", kPmdSensor, Condition::kStereoLost, 0,
       with_fault(&Faults::stereo, FaultKind::kVanish)},
      {"pair silent", kPmdSensor, Condition::kStereoSilent, 0,
       with_fault(&Faults::stereo, FaultKind::kDrop)},
      {"pair damaged", kPmdSensor, Condition::kStereoSilent, 0,
       with_fault(&Faults::stereo, FaultKind::kCorrupt)},
      {"pair torn", kPmdSensor, Condition::kStereoSilent, 0,
       with_fault(&Faults::stereo, FaultKind::kTear)},
      {"pair repeats its last frame", kPmdSensor, Condition::kStereoFrozen, kLeftEye | kRightEye,
       with_fault(&Faults::stereo, FaultKind::kRepeat)},
      {"left picture frozen", kPmdSensor, Condition::kStereoFrozen, kLeftEye,
       with_pixels(&PixelFaults::left, false)},
      {"right picture frozen", kPmdSensor, Condition::kStereoFrozen, kRightEye,
       with_pixels(&PixelFaults::right, false)},
      {"both pictures frozen", kPmdSensor, Condition::kStereoFrozen, kLeftEye | kRightEye,
       with_frozen_pair()},
      {"PMD unplugged", kStereoSensor, Condition::kPmdLost, 0,
       with_fault(&Faults::pmd, FaultKind::kVanish)},
      {"PMD silent", kStereoSensor, Condition::kPmdSilent, 0,
       with_fault(&Faults::pmd, FaultKind::kDrop)},
      {"PMD torn", kStereoSensor, Condition::kPmdSilent, 0,
       with_fault(&Faults::pmd, FaultKind::kTear)},
      {"PMD repeats its last frame", kStereoSensor, Condition::kPmdFrozen, 0,
       with_fault(&Faults::pmd, FaultKind::kRepeat)},
      {"PMD samples frozen", kStereoSensor, Condition::kPmdFrozen, 0,
       with_pixels(&PixelFaults::pmd, false)},
      {"PMD lamp dark", kStereoSensor, Condition::kPmdDark, 0,
       with_pixels(&PixelFaults::pmd, true)},
  };
}

struct OutageRun {
  Rig rig;
  Receiver receiver;

  explicit OutageRun(const RigOptions& options) : rig(options) {
    for (std::uint32_t i = 0; i < kFirst + kEdges + kAfter; ++i) {
      static_cast<void>(rig.loop.step());
      rig.publisher.report({});
      receiver.drain(rig.port);
    }
  }
  std::size_t edge_of(const Received& frame) const {
    return rig.log.find(hal::Time(hal::Duration(frame.info.exposure_begin_ns))).value();
  }
  // When that condition began or ended for the first time, since that edge; none: never.
  std::optional<hal::Duration> told(Condition condition, bool active, std::uint32_t edge) const {
    for (const wire::EventReport& event : receiver.events) {
      if (event.condition == static_cast<std::uint8_t>(condition) &&
          (event.active != 0) == active) {
        return hal::Time(hal::Duration(event.at_ns)) - rig.log.edges[edge];
      }
    }
    return std::nullopt;
  }
};

class LostSensor : public testing::TestWithParam<Outage> {};

TEST_P(LostSensor, TheOtherOneGoesOnAtTheSameRateAndBothAreBackAtOnce) {
  const OutageRun run(GetParam().options);
  const std::vector<std::size_t> edges = expect_true_frames(run.rig, run.receiver);
  EXPECT_GE(edges.size(), std::size_t{kFirst + kEdges + kAfter} - 1)
      << "no edge is without a frame";
  EXPECT_EQ(run.rig.events.counters.skipped_periods, 0U);
  EXPECT_EQ(run.rig.events.counters.late_edges, 0U);
  for (const auto& [number, frame] : run.receiver.frames) {
    const std::size_t edge = run.edge_of(frame);
    const bool out = edge >= kFirst && edge < kFirst + kEdges;
    EXPECT_EQ(frame.info.sensors, out ? GetParam().left : kBothSensors) << "edge " << edge;
    EXPECT_EQ(frame.stamp.health == wire::Health::kOk, !out) << "edge " << edge;
    if (testing::Test::HasFailure()) {
      break;
    }
  }
}

TEST_P(LostSensor, ItIsToldWithinThreeTenthsOfASecondAndNothingElseIs) {
  const OutageRun run(GetParam().options);
  const auto began = run.told(GetParam().condition, true, kFirst);
  ASSERT_TRUE(began);
  EXPECT_GE(*began, 0ms);
  EXPECT_LE(*began, 300ms);
  const auto ended = run.told(GetParam().condition, false, kFirst + kEdges);
  ASSERT_TRUE(ended);
  EXPECT_GE(*ended, 0ms);
  EXPECT_LE(*ended, 2 * kPeriod);
  for (const wire::EventReport& event : run.receiver.events) {
    EXPECT_EQ(event.condition, static_cast<std::uint8_t>(GetParam().condition));
    EXPECT_EQ(event.reaction, wire::Reaction::kSlow);
    EXPECT_EQ(event.count, 1U);
    if (event.active != 0) {
      EXPECT_EQ(event.value, GetParam().value);
    }
  }
}

TEST_P(LostSensor, WithBothRequiredThereIsNoFrameAndTheRobotStops) {
  RigOptions options = GetParam().options;
  options.require_both = true;
  const OutageRun run(options);
  for (const std::size_t edge : expect_true_frames(run.rig, run.receiver)) {
    EXPECT_TRUE(edge < kFirst || edge >= kFirst + kEdges) << edge;
  }
  EXPECT_GE(run.receiver.frames.size(), std::size_t{kFirst} + kAfter - 2);
  const auto began = run.told(Condition::kNoFrames, true, kFirst);
  ASSERT_TRUE(began);
  EXPECT_LE(*began, 300ms);
  EXPECT_TRUE(run.told(GetParam().condition, true, kFirst));
  const auto stopping = std::ranges::count_if(
      run.receiver.healths,
      [](const wire::HealthReport& health) { return health.reaction == wire::Reaction::kStop; });
  EXPECT_GE(stopping, 9) << "once a second";
}

std::string name_of(const testing::TestParamInfo<Outage>& info) {
  std::string name = info.param.name;
  std::ranges::replace(name, ' ', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Outages, LostSensor, testing::ValuesIn(outages()), name_of);

// To the bit, also after frames of both.
TEST(LostSensors, ThePairAloneGivesTheDepthOfARigWithoutAPmdCamera) {
  const OutageRun lost(with_fault(&Faults::pmd, emu::FaultKind::kVanish));
  const OutageRun without(RigOptions{.with_pmd = false});
  ASSERT_EQ(lost.receiver.frames.size(), without.receiver.frames.size());
  for (std::uint32_t number = kFirst; number < kFirst + kEdges; ++number) {
    const Received& frame = lost.receiver.frames.at(number);
    const Received& alone = without.receiver.frames.at(number);
    ASSERT_EQ(frame.info.exposure_begin_ns, alone.info.exposure_begin_ns);
    EXPECT_EQ(frame.depth, alone.depth) << number;
    EXPECT_EQ(frame.source, alone.source) << number;
    EXPECT_EQ(alone.stamp.health, wire::Health::kOk) << "it is all that this rig has";
  }
}

// A lamp that never shone, with depth averaged over frames: nothing of its samples is published,
// then or later.
TEST(LostSensors, ALampThatIsDarkFromTheStartGivesNoDepthAndIsTold) {
  RigOptions options;
  options.still = true;
  options.temporal = true;
  options.pixels.pmd = {.first = 0, .edges = kFirst, .dark = true};
  const OutageRun run(options);
  const OutageRun without(RigOptions{.with_pmd = false, .still = true, .temporal = true});
  RigOptions silent = options;
  silent.pixels = {};
  silent.faults.pmd = {emu::Fault{.kind = emu::FaultKind::kDrop, .call = 0, .calls = kFirst}};
  const OutageRun never(silent);
  const auto began = run.told(Condition::kPmdDark, true, 0);
  ASSERT_TRUE(began);
  EXPECT_LE(*began, 300ms);
  const auto ended = run.told(Condition::kPmdDark, false, kFirst);
  ASSERT_TRUE(ended);
  EXPECT_LE(*ended, 2 * kPeriod);
  ASSERT_GE(run.receiver.frames.size(), std::size_t{kFirst} + kAfter);
  for (const auto& [number, frame] : run.receiver.frames) {
    const bool dark = run.edge_of(frame) < kFirst;
    ASSERT_EQ(frame.info.sensors, dark ? kStereoSensor : kBothSensors) << number;
    const OutageRun& same = dark ? without : never;
    const Received& alike = same.receiver.frames.at(number);
    ASSERT_EQ(same.edge_of(alike), run.edge_of(frame));
    EXPECT_EQ(frame.depth, alike.depth) << number;
    EXPECT_EQ(frame.source, alike.source) << number;
    EXPECT_EQ(frame.info.steady_frames, alike.info.steady_frames) << number;
  }
}

// Its frame may be paced over the whole period.
TEST(LostSensors, ALossIsToldBeforeTheFrameOfItsEdge) {
  Rig rig(with_fault(&Faults::pmd, emu::FaultKind::kVanish));
  Receiver before;
  run(rig, before, kFirst);
  EXPECT_TRUE(before.events.empty());
  static_cast<void>(rig.loop.step());
  std::vector<wire::PacketType> sent;
  while (const auto datagram = rig.port.take_sent()) {
    sent.push_back(wire::parse_packet(datagram->bytes).value().header.type);
  }
  ASSERT_FALSE(sent.empty());
  EXPECT_EQ(sent.front(), wire::PacketType::kEvent);
  EXPECT_EQ(std::ranges::count(sent, wire::PacketType::kEvent), 1);
  EXPECT_EQ(std::ranges::count(sent, wire::PacketType::kFrameInfo), 1);
}

// Of which nothing can be said: no noise, no depth either. The sensors stay in use.
TEST(LostSensors, ACoveredPairIsBlindAndNotFrozen) {
  RigOptions options = with_pixels(&PixelFaults::left, true);
  options.pixels.right = options.pixels.left;
  const OutageRun run(options);
  EXPECT_FALSE(run.receiver.events.empty());
  for (const wire::EventReport& event : run.receiver.events) {
    EXPECT_EQ(static_cast<wire::Condition>(event.condition), wire::Condition::kStereoBlind);
  }
  for (const auto& [number, frame] : run.receiver.frames) {
    EXPECT_EQ(frame.info.sensors, kBothSensors);
  }
}

// One frame of a sensor that comes too late for its edge, or never: the frame of that edge waits
// for it until the next edge and goes out without, nothing that follows waits, and nobody is told.
TEST(LostSensors, OneMissingFrameDelaysNoEdge) {
  for (emu::FaultPlan Faults::* const device : {&Faults::stereo, &Faults::pmd}) {
    for (const hal::Duration late : {0ms, 30ms, 40ms}) {
      RigOptions options;
      options.faults.*
          device = {emu::Fault{.kind = late == 0ms ? emu::FaultKind::kDrop : emu::FaultKind::kDelay,
                               .call = kFirst,
                               .duration = late}};
      const OutageRun run(options);
      expect_true_frames(run.rig, run.receiver);
      EXPECT_EQ(run.rig.events.counters.skipped_periods, 0U);
      EXPECT_EQ(run.rig.events.counters.unpaired_edges, 0U);
      EXPECT_TRUE(run.receiver.events.empty());
      int partial = 0;
      for (const auto& [number, frame] : run.receiver.frames) {
        const bool whole = frame.info.sensors == kBothSensors;
        partial += whole ? 0 : 1;
        EXPECT_LE(hal::Duration(frame.info.latency_ns),
                  whole && number > 0 ? kPeriod : 2 * kPeriod);
      }
      EXPECT_GE(partial, 1);
      EXPECT_LE(partial, 2);
    }
  }
}

TEST(LostSensors, WithoutAnySensorTheRobotStopsAndBothComeBack) {
  RigOptions options = with_fault(&Faults::stereo, emu::FaultKind::kVanish);
  options.faults.pmd = options.faults.stereo;
  const OutageRun run(options);
  EXPECT_GE(expect_true_frames(run.rig, run.receiver).size(), std::size_t{kFirst} + kAfter - 1);
  const auto began = run.told(Condition::kNoFrames, true, kFirst);
  ASSERT_TRUE(began);
  EXPECT_LE(*began, 300ms);
  EXPECT_EQ(run.receiver.frames.rbegin()->second.info.sensors, kBothSensors);
}

}  // namespace
}  // namespace stof::firmware::test
