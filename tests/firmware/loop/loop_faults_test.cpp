#include <algorithm>
#include <string>

#include <gtest/gtest.h>

#include "tests/firmware/rig.h"

namespace stof::firmware::test {
namespace {

constexpr std::uint32_t kCalls = 13;  // of the device: the fault strikes each of them once
constexpr int kSteps = 26;

struct Case {
  emu::FaultKind kind;
  hal::Duration duration;
};
// Delays that stay in the period, reach into the next one, and pass over it; a second edge during
// the exposures, between the frames, and just before the next edge.
constexpr std::array kCases{
    Case{emu::FaultKind::kDrop, 0ms},    Case{emu::FaultKind::kDelay, 5ms},
    Case{emu::FaultKind::kDelay, 25ms},  Case{emu::FaultKind::kDelay, 40ms},
    Case{emu::FaultKind::kDelay, 70ms},  Case{emu::FaultKind::kRepeat, 2ms},
    Case{emu::FaultKind::kRepeat, 12ms}, Case{emu::FaultKind::kRepeat, 31ms},
    Case{emu::FaultKind::kTear, 0ms},    Case{emu::FaultKind::kCorrupt, 0ms},
    Case{emu::FaultKind::kVanish, 0ms}};

emu::FaultPlan once(const Case& fault, std::uint32_t call, std::uint32_t calls = 1) {
  return {emu::Fault{.kind = fault.kind, .call = call, .calls = calls, .duration = fault.duration}};
}

std::string name(const Case& fault, std::uint32_t call) {
  return "kind " + std::to_string(static_cast<int>(fault.kind)) + ", duration " +
         std::to_string(fault.duration / 1ms) + " ms, call " + std::to_string(call);
}

// The longest time between two edges whose frames were published, in periods; including the start.
double longest_gap(const Rig& rig, const std::vector<std::size_t>& edges) {
  hal::Time before = rig.log.edges.front();
  hal::Duration longest{};
  for (const std::size_t edge : edges) {
    longest = std::max(longest, rig.log.edges[edge] - before);
    before = rig.log.edges[edge];
  }
  longest = std::max(longest, rig.log.edges.back() - before);
  return static_cast<double>(longest.count()) / static_cast<double>(hal::Duration(33ms).count());
}

// One fault at every call number: only true frames, and never more than three periods without one,
// on top of the time that a trigger blocks against its promise.
template <emu::FaultPlan Faults::* kDevice>
void strike_each_call(bool require_both) {
  for (const Case& fault : kCases) {
    for (std::uint32_t call = 0; call < kCalls; ++call) {
      SCOPED_TRACE(name(fault, call));
      RigOptions options;
      options.faults.*kDevice = once(fault, call);
      options.require_both = require_both;
      Rig rig(options);
      Receiver receiver;
      run(rig, receiver, kSteps);
      const std::vector<std::size_t> edges = expect_true_frames(rig, receiver);
      EXPECT_GE(edges.size(), static_cast<std::size_t>(kSteps) - 6);
      const bool blocks = kDevice == &Faults::trigger && fault.duration > 33ms;
      EXPECT_LE(longest_gap(rig, edges),
                3.01 + (blocks ? static_cast<double>(fault.duration / 33ms) : 0));
      EXPECT_EQ(receiver.damaged, 0U);
      EXPECT_EQ(rig.events.counters.published, receiver.frames.size());
    }
  }
}

TEST(LoopFaults, TriggerFaultsAtEveryCallCostAFewPeriodsAndNoTruth) {
  strike_each_call<&Faults::trigger>(false);
  strike_each_call<&Faults::trigger>(true);
}
TEST(LoopFaults, StereoFaultsAtEveryCallCostAFewPeriodsAndNoTruth) {
  strike_each_call<&Faults::stereo>(false);
  strike_each_call<&Faults::stereo>(true);
}
TEST(LoopFaults, PmdFaultsAtEveryCallCostAFewPeriodsAndNoTruth) {
  strike_each_call<&Faults::pmd>(false);
  strike_each_call<&Faults::pmd>(true);
}

// The detector that the tests above rely on.
TEST(LoopFaults, AFramePaintedFromAnotherEdgeWouldBeNoticed) {
  Rig rig;
  Receiver receiver;
  run(rig, receiver, 5);
  for (const auto& [number, frame] : receiver.frames) {
    const std::size_t edge =
        rig.log.find(hal::Time(hal::Duration(frame.info.exposure_begin_ns))).value();
    for (std::size_t other = edge + 1; other < edge + 7; ++other) {
      EXPECT_GT(std::abs(frame.depth_m() - depth_of(other)), 0.04 * depth_of(other));
    }
  }
}

// A packet that the link spoils is no concern of the loop: the rest arrives, complete and true.
TEST(LoopFaults, LinkFaultsAtEveryCallCostTheFrameTheyStrike) {
  for (const Case& fault : kCases) {
    for (std::uint32_t call = 0; call < kCalls; ++call) {
      SCOPED_TRACE(name(fault, call));
      RigOptions options;
      options.faults.link = once(fault, call);
      Rig rig(options);
      Receiver receiver;
      run(rig, receiver, kSteps);
      EXPECT_GE(expect_true_frames(rig, receiver).size(), static_cast<std::size_t>(kSteps) - 3);
      EXPECT_EQ(rig.events.counters.published, static_cast<std::uint64_t>(kSteps));
    }
  }
}

TEST(LoopFaults, AllDevicesFailingNowAndThenStillGivesOnlyTrueFrames) {
  for (const Case& fault : kCases) {
    SCOPED_TRACE(name(fault, 0));
    const auto now_and_then = [&](std::uint32_t call, std::uint32_t every) {
      return emu::FaultPlan{
          emu::Fault{.kind = fault.kind, .call = call, .every = every, .duration = fault.duration}};
    };
    Rig rig({.faults = {.trigger = now_and_then(4, 17),
                        .stereo = now_and_then(2, 7),
                        .pmd = now_and_then(3, 11)}});
    Receiver receiver;
    run(rig, receiver, 150);
    EXPECT_GE(expect_true_frames(rig, receiver).size(), 50U);
  }
}

TEST(LoopFaults, LongOutagesEndTwoPeriodsAfterTheDeviceIsBack) {
  for (const Case& fault : kCases) {
    if (fault.kind == emu::FaultKind::kDelay) {
      continue;  // a pipe that is late for good never catches up
    }
    for (emu::FaultPlan Faults::* const device :
         {&Faults::trigger, &Faults::stereo, &Faults::pmd}) {
      SCOPED_TRACE(name(fault, 0));
      RigOptions options;
      options.faults.*device = once(fault, 5, 40);
      Rig rig(options);
      Receiver receiver;
      run(rig, receiver, 46);
      const std::size_t during = receiver.frames.size();
      run(rig, receiver, 12);
      expect_true_frames(rig, receiver);
      EXPECT_GE(receiver.frames.size(), during + 9);
    }
  }
}

TEST(LoopFaults, ALostDeviceIsReportedUpwardsUntilItIsBack) {
  for (emu::FaultPlan Faults::* const device : {&Faults::trigger, &Faults::stereo, &Faults::pmd}) {
    RigOptions options;
    options.faults.*device = once({emu::FaultKind::kVanish, 0ms}, 3, 4);
    Rig rig(options);
    int lost = 0;
    for (int i = 0; i < 12; ++i) {
      lost += rig.loop.step() == Status::kDeviceLost ? 1 : 0;
    }
    EXPECT_EQ(lost, 4);
    int began = 0;
    int ended = 0;
    while (const auto event = rig.events.take()) {
      began += event->kind == EventKind::kLost ? 1 : 0;
      ended += event->kind == EventKind::kBack ? 1 : 0;
    }
    EXPECT_EQ(began, 1);
    EXPECT_EQ(ended, 1);
  }
}

TEST(LoopFaults, DroppedFramesAreCountedByCause) {
  const auto stereo = [](emu::FaultKind kind, hal::Duration duration, Drop cause) {
    Rig rig({.faults = {.stereo = once({kind, duration}, 5)}, .require_both = true});
    Receiver receiver;
    run(rig, receiver, 12);
    return of(rig.events.counters.stereo_dropped, cause);
  };
  EXPECT_EQ(stereo(emu::FaultKind::kTear, 0ms, Drop::kTorn), 1U);
  EXPECT_EQ(stereo(emu::FaultKind::kRepeat, 0ms, Drop::kStale), 1U);
  EXPECT_EQ(stereo(emu::FaultKind::kDelay, 40ms, Drop::kOlderEdge), 1U);
  EXPECT_EQ(stereo(emu::FaultKind::kDrop, 0ms, Drop::kOlderEdge), 0U);
  Rig lonely({.faults = {.stereo = once({emu::FaultKind::kDrop, 0ms}, 5)}, .require_both = true});
  Receiver nothing;
  run(lonely, nothing, 12);
  EXPECT_EQ(of(lonely.events.counters.pmd_dropped, Drop::kUnpartnered), 1U);
  EXPECT_EQ(of(lonely.events.counters.timeouts, Component::kStereo), 1U);
  Rig rig({.faults = {.pmd = once({emu::FaultKind::kTear, 0ms}, 5)}, .require_both = true});
  Receiver receiver;
  run(rig, receiver, 12);
  EXPECT_EQ(of(rig.events.counters.pmd_dropped, Drop::kTorn), 1U);
  EXPECT_EQ(of(rig.events.counters.stereo_dropped, Drop::kUnpartnered), 1U);
  EXPECT_EQ(rig.events.counters.unpaired_edges, 1U);
}

// A second edge exposes a frame that nobody asked for; it comes damaged, before the right one.
TEST(LoopFaults, ADamagedFrameThatWasLeftOverDoesNotHideTheRightOne) {
  Rig rig({.faults = {.trigger = once({emu::FaultKind::kRepeat, 12ms}, 5),
                      .stereo = once({emu::FaultKind::kCorrupt, 0ms}, 6),
                      .pmd = {}}});
  Receiver receiver;
  run(rig, receiver, 8);
  ASSERT_EQ(of(rig.events.counters.errors, Component::kStereo), 1U);
  EXPECT_EQ(rig.events.counters.unpaired_edges, 0U);
}

TEST(LoopFaults, WithoutPmdCameraStereoAloneIsPublishedAndSaidSo) {
  Rig rig({.with_pmd = false});
  Receiver receiver;
  run(rig, receiver, 10);
  ASSERT_EQ(receiver.frames.size(), 10U);
  std::uint32_t freshness = 0;
  for (const auto& [number, frame] : receiver.frames) {
    EXPECT_FALSE(frame.info.pmd_present);
    EXPECT_GT(frame.count(dsp::Source::kStereo), frame.source.size() / 3);
    EXPECT_EQ(frame.count(dsp::Source::kBoth) + frame.count(dsp::Source::kPmd), 0U);
    EXPECT_EQ(frame.stamp.freshness, ++freshness);
  }
}

// The PMD camera exposes at every third edge: its data serve the edges that follow, with their age.
// Every frame has a new exposure of the pair, and is fresh.
TEST(LoopFaults, ASlowPmdCameraLendsItsDataWithTheirAge) {
  RigOptions options;
  options.require_both = true;
  options.timing.pmd_every = 3;
  options.timing.pmd_integration = 80ms;
  Rig rig(options);
  Receiver receiver;
  run(rig, receiver, 40);
  EXPECT_GE(receiver.frames.size(), 35U);
  std::map<std::size_t, int> uses;  // of the PMD data of an edge
  std::uint32_t freshness = 0;
  for (const auto& [number, frame] : receiver.frames) {
    const auto edge = rig.log.find(hal::Time(hal::Duration(frame.info.exposure_begin_ns)));
    ASSERT_TRUE(edge);
    // Middle of 4 ms at this edge less middle of 80 ms at the PMD camera's.
    const hal::Duration age = hal::Duration(frame.info.pmd_age_ns) + 40ms - 2ms;
    EXPECT_EQ(age % 33ms, 0ms);
    EXPECT_LE(age, 4 * 33ms);
    const auto pmd_edge = *edge - static_cast<std::size_t>(age / 33ms);
    EXPECT_EQ(pmd_edge % 3, 0U) << "the camera did not expose at this edge";
    ++uses[pmd_edge];
    EXPECT_GT(frame.stamp.freshness, freshness);
    freshness = frame.stamp.freshness;
  }
  for (const auto& [edge, count] : uses) {
    EXPECT_LE(count, 3) << edge;
  }
  EXPECT_NEAR(static_cast<double>(uses.size()), 12, 1);
}

TEST(LoopFaults, WithBothRequiredASlowPmdCameraThatFailsStopsPublishingUntilItsNextFrame) {
  for (const emu::FaultKind kind : emu::kAllFaultKinds) {
    RigOptions options;
    options.timing.pmd_every = 3;
    options.timing.pmd_integration = 80ms;
    options.faults.pmd = once({kind, 30ms}, 3, 2);
    options.require_both = true;
    Rig rig(options);
    Receiver receiver;
    run(rig, receiver, 60);
    EXPECT_GE(receiver.frames.size(), 45U);
    for (const auto& [number, frame] : receiver.frames) {
      EXPECT_LE(hal::Duration(frame.info.pmd_age_ns) + 40ms - 2ms, 4 * 33ms);
    }
  }
}

TEST(LoopFaults, TwoRunsSendTheSameBytes) {
  const auto bytes = [] {
    Rig rig({.faults = {.stereo = once({emu::FaultKind::kRepeat, 0ms}, 6),
                        .pmd = once({emu::FaultKind::kVanish, 0ms}, 9, 3)}});
    Receiver receiver;
    run(rig, receiver, 40);
    return receiver.bytes;
  };
  const std::vector<std::byte> first = bytes();
  EXPECT_GT(first.size(), 30U * 1000U);
  EXPECT_TRUE(first == bytes());
}

}  // namespace
}  // namespace stof::firmware::test
