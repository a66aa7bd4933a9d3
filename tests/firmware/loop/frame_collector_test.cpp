#include "firmware/loop/frame_collector.h"

#include <gtest/gtest.h>

#include "tests/firmware/rig.h"

namespace stof::firmware::test {
namespace {

constexpr hal::Duration kPeriod = 33ms;

// The collector alone, on the rig's trigger and cameras.
class Collection {
 public:
  explicit Collection(const RigOptions& options = {}) : timing_(options.timing), rig_(options) {}

  // The next edge of the grid.
  Collected next() {
    rig_.clock.wait_until(start_ + edges_++ * kPeriod);
    edge_ = rig_.trigger.pulse().value();
    return collector_.collect(edge_, edge_ + kPeriod, timing_, nullptr);
  }
  hal::Time edge() const { return edge_; }
  const Counters& counters() const { return rig_.events.counters; }
  hal::Time now() { return rig_.clock.now(); }

 private:
  board::TimingConfig timing_;
  Rig rig_;
  LoopConditions conditions_{rig_.clock, rig_.events, rig_.publisher.health()};
  FrameCollector collector_{rig_.board, rig_.setup, conditions_};
  hal::Time start_ = rig_.clock.now();
  hal::Time edge_{};
  int edges_ = 0;
};

emu::FaultPlan fault(emu::FaultKind kind, std::uint32_t call, std::uint32_t calls = 1) {
  return {emu::Fault{.kind = kind, .call = call, .calls = calls}};
}

TEST(FrameCollector, AShotHasTheFramesOfItsEdge) {
  Collection collection;
  for (std::uint32_t freshness = 1; freshness < 5; ++freshness) {
    const Collected collected = collection.next();
    ASSERT_TRUE(collected.shot);
    EXPECT_FALSE(collected.lost);
    const Shot& shot = *collected.shot;
    EXPECT_EQ(shot.edge, collection.edge());
    EXPECT_EQ(shot.exposed, collection.edge() + 2ms);
    EXPECT_EQ((*shot.stereo)->left_exposure.begin, collection.edge());
    ASSERT_TRUE(shot.pmd);
    EXPECT_EQ(shot.pmd_exposed, collection.edge() + 8ms);
    EXPECT_EQ(shot.freshness, freshness);
    EXPECT_EQ(shot.missed_edges, 0U);
  }
}

TEST(FrameCollector, WithBothRequiredThereIsNoShotWithoutOneAndTheOthersFrameIsDropped) {
  Collection collection({.faults = {.stereo = fault(emu::FaultKind::kDrop, 1),
                                    .pmd = fault(emu::FaultKind::kDrop, 2)},
                         .require_both = true});
  EXPECT_TRUE(collection.next().shot);
  EXPECT_FALSE(collection.next().shot);
  EXPECT_EQ(collection.now(), collection.edge() + kPeriod) << "waits until the deadline";
  EXPECT_EQ(of(collection.counters().pmd_dropped, Drop::kUnpartnered), 1U);
  EXPECT_EQ(of(collection.counters().timeouts, Component::kStereo), 1U);
  EXPECT_FALSE(collection.next().shot);
  EXPECT_EQ(of(collection.counters().stereo_dropped, Drop::kUnpartnered), 1U);
  const Collected collected = collection.next();
  ASSERT_TRUE(collected.shot);
  EXPECT_EQ(collected.shot->missed_edges, 2U);
  EXPECT_EQ(collected.shot->freshness, 2U);
  EXPECT_EQ(collection.counters().unpaired_edges, 2U);
}

TEST(FrameCollector, ADamagedOrRepeatedFrameIsNotTheEdges) {
  Collection collection({.faults = {.stereo = fault(emu::FaultKind::kRepeat, 1),
                                    .pmd = fault(emu::FaultKind::kCorrupt, 3)},
                         .require_both = true});
  EXPECT_TRUE(collection.next().shot);
  EXPECT_FALSE(collection.next().shot);
  EXPECT_EQ(of(collection.counters().stereo_dropped, Drop::kStale), 1U);
  EXPECT_TRUE(collection.next().shot);
  EXPECT_FALSE(collection.next().shot);
  EXPECT_EQ(of(collection.counters().errors, Component::kPmd), 1U);
}

TEST(FrameCollector, ALostCameraIsToldAndMayCountAnewWhenItIsBack) {
  for (emu::FaultPlan Faults::* const camera : {&Faults::stereo, &Faults::pmd}) {
    RigOptions options;
    options.faults.*camera = fault(emu::FaultKind::kVanish, 1, 2);
    options.require_both = true;
    Collection collection(options);
    EXPECT_TRUE(collection.next().shot);
    for (int i = 0; i < 2; ++i) {
      const Collected collected = collection.next();
      EXPECT_FALSE(collected.shot);
      EXPECT_TRUE(collected.lost);
    }
    EXPECT_TRUE(collection.next().shot);
  }
}

TEST(FrameCollector, ASlowPmdCamerasDataServeTheEdgesThatFollow) {
  RigOptions options;
  options.timing.pmd_every = 3;
  options.timing.pmd_integration = 80ms;
  options.faults.pmd = fault(emu::FaultKind::kDrop, 2, 2);
  options.require_both = true;
  Collection collection(options);
  int fresh = 0;
  int shots = 0;
  for (int i = 0; i < 18; ++i) {
    const Collected collected = collection.next();
    if (!collected.shot) {
      continue;
    }
    ++shots;
    fresh += collected.shot->pmd ? 1 : 0;
    ASSERT_TRUE(collected.shot->pmd_exposed);
    // Middle of 80 ms, four periods ago at the oldest.
    EXPECT_GE(*collected.shot->pmd_exposed, collection.edge() + 40ms - 4 * kPeriod);
  }
  EXPECT_EQ(fresh, 4);
  EXPECT_EQ(shots, 10) << "edges 2 to 4, 5 to 7, 14 to 16, and 17";
  EXPECT_EQ(of(collection.counters().pmd_dropped, Drop::kUnpartnered), 0U);
}

TEST(FrameCollector, WithoutThePmdCamerasSamplesThePairIsAShot) {
  for (const emu::FaultKind kind :
       {emu::FaultKind::kDrop, emu::FaultKind::kCorrupt, emu::FaultKind::kVanish}) {
    Collection collection({.faults = {.pmd = fault(kind, 1)}});
    EXPECT_EQ(collection.next().shot->sensors(), kBothSensors);
    const Collected collected = collection.next();
    ASSERT_TRUE(collected.shot);
    EXPECT_EQ(collected.shot->sensors(), kStereoSensor);
    EXPECT_FALSE(collected.shot->pmd);
    EXPECT_EQ(collected.shot->exposed, collection.edge() + 2ms);
    EXPECT_EQ(collected.shot->freshness, 2U);
    EXPECT_LE(collection.now(), collection.edge() + kPeriod);
    EXPECT_EQ(collection.next().shot->sensors(), kBothSensors);
    EXPECT_EQ(of(collection.counters().stereo_dropped, Drop::kUnpartnered), 0U);
    EXPECT_EQ(collection.counters().unpaired_edges, 0U);
  }
}

TEST(FrameCollector, WithoutAPairThePmdCamerasSamplesAreAShotOfTheirOwnTime) {
  for (const emu::FaultKind kind : {emu::FaultKind::kDrop, emu::FaultKind::kRepeat,
                                    emu::FaultKind::kTear, emu::FaultKind::kVanish}) {
    Collection collection({.faults = {.stereo = fault(kind, 1)}});
    EXPECT_TRUE(collection.next().shot);
    const Collected collected = collection.next();
    ASSERT_TRUE(collected.shot);
    EXPECT_EQ(collected.shot->sensors(), kPmdSensor);
    EXPECT_TRUE(collected.shot->pmd);
    EXPECT_EQ(collected.shot->exposed, collection.edge() + 8ms);
    EXPECT_EQ(collected.shot->pmd_exposed, collected.shot->exposed);
    EXPECT_EQ(collected.shot->freshness, 2U);
    EXPECT_EQ(collection.next().shot->sensors(), kBothSensors);
    EXPECT_EQ(of(collection.counters().pmd_dropped, Drop::kUnpartnered), 0U);
  }
}

// Alone it has something new at every third edge only, and the edges between are no failures.
TEST(FrameCollector, ASlowPmdCameraAloneGivesAShotForEachOfItsExposures) {
  RigOptions options;
  options.timing.pmd_every = 3;
  options.timing.pmd_integration = 80ms;
  options.faults.stereo = fault(emu::FaultKind::kDrop, 7, 12);
  Collection collection(options);
  std::vector<hal::Time> exposed;
  int alone = 0;
  for (int i = 0; i < 22; ++i) {
    const Collected collected = collection.next();
    if (collected.shot) {
      EXPECT_TRUE(exposed.empty() || collected.shot->exposed > exposed.back());
      exposed.push_back(collected.shot->exposed);
      alone += collected.shot->sensors() == kPmdSensor ? 1 : 0;
    }
  }
  EXPECT_EQ(alone, 4) << "one of three edges";
  EXPECT_EQ(collection.counters().unpaired_edges, 0U);
}

TEST(FrameCollector, WithoutAnythingThereIsNoShot) {
  Collection collection({.faults = {.stereo = fault(emu::FaultKind::kDrop, 1),
                                    .pmd = fault(emu::FaultKind::kDrop, 1)}});
  EXPECT_TRUE(collection.next().shot);
  EXPECT_FALSE(collection.next().shot);
  EXPECT_EQ(collection.counters().unpaired_edges, 1U);
  EXPECT_EQ(collection.next().shot->missed_edges, 1U);
}

TEST(FrameCollector, WithoutPmdCameraThePairIsAShot) {
  Collection collection({.with_pmd = false});
  const Collected collected = collection.next();
  ASSERT_TRUE(collected.shot);
  EXPECT_FALSE(collected.shot->pmd || collected.shot->pmd_exposed);
}

}  // namespace
}  // namespace stof::firmware::test
