#include <gtest/gtest.h>

#include "tests/firmware/rig.h"

// After a gap in the frames depth is averaged with none that came before it.
namespace stof::firmware::test {
namespace {

constexpr std::uint32_t kGap = 20;  // the edge that it begins with
constexpr int kSteps = 40;

// Depth of the last frame of a rig before which nothing moves, which is asked to `act` at kGap.
template <typename Act>
std::vector<std::uint16_t> last_depth(const RigOptions& of, Act act) {
  RigOptions options = of;
  options.still = true;
  options.temporal = true;
  Rig rig(options);
  Receiver receiver;
  run(rig, receiver, kGap);
  act(rig.loop);
  run(rig, receiver, kSteps - kGap);
  EXPECT_FALSE(receiver.frames.empty());
  return receiver.frames.rbegin()->second.depth;
}

std::vector<std::uint16_t> last_depth(const RigOptions& options) {
  return last_depth(options, [](Loop&) {});
}

// Where a frame needs both sensors.
std::vector<std::uint16_t> last_depth_of_both(const Faults& faults) {
  return last_depth({.faults = faults, .require_both = true});
}

emu::Fault no_frame(std::uint32_t first, std::uint32_t edges) {
  return {.kind = emu::FaultKind::kDrop, .call = first, .calls = edges};
}

// Of a rig whose first frame is that of this edge.
std::vector<std::uint16_t> without_past(std::uint32_t first) {
  return last_depth_of_both({.stereo = {no_frame(0, first)}});
}

TEST(LoopGap, TheNoiseOfThisRigIsAveraged) { EXPECT_NE(last_depth({}), without_past(kGap)); }

TEST(LoopGap, ThreeEdgesWithoutAFrameAreAGapFewerAreNot) {
  EXPECT_EQ(last_depth_of_both({.stereo = {no_frame(kGap, 3)}}), without_past(kGap + 3));
  EXPECT_EQ(last_depth_of_both({.pmd = {no_frame(kGap, 3)}}), without_past(kGap + 3));
  EXPECT_EQ(last_depth_of_both({.stereo = {no_frame(kGap, 15)}}), without_past(kGap + 15));
  EXPECT_NE(last_depth_of_both({.stereo = {no_frame(kGap, 2)}}), without_past(kGap + 2));
}

TEST(LoopGap, ALostStereoCameraIsAGapHoweverSoonItIsBack) {
  const emu::Fault lost{.kind = emu::FaultKind::kVanish, .call = kGap};
  EXPECT_EQ(last_depth_of_both({.stereo = {lost}}), without_past(kGap + 1));
  EXPECT_NE(last_depth_of_both({.pmd = {lost}}), without_past(kGap + 1));
}

// With other sensors than before nothing is averaged with what was before, however soon the missing
// one is back.
TEST(LoopGap, AnotherSetOfSensorsIsAGap) {
  for (emu::FaultPlan Faults::* const sensor : {&Faults::stereo, &Faults::pmd}) {
    for (const std::uint32_t edges : {1U, 2U, 5U}) {
      Faults faults;
      faults.*sensor = {no_frame(kGap, edges)};
      EXPECT_EQ(last_depth({.faults = faults}), without_past(kGap + edges)) << edges;
    }
  }
}

// Of the last frame of a rig that needs both sensors and whose first frame is that of edge `first`.
std::uint32_t steady_frames(bool temporal, std::uint32_t first, std::uint32_t lost) {
  Rig rig({.faults = {.stereo = {no_frame(first, lost)}},
           .still = true,
           .temporal = temporal,
           .require_both = true});
  Receiver receiver;
  run(rig, receiver, kSteps);
  return receiver.frames.rbegin()->second.info.steady_frames;
}

TEST(LoopGap, AFrameSaysOnHowManyItStands) {
  const std::uint32_t all = steady_frames(true, 0, 0);
  EXPECT_GE(all + 2, std::uint32_t{kSteps});
  EXPECT_EQ(steady_frames(true, kGap, 3), all - kGap - 3);
  EXPECT_EQ(steady_frames(true, kGap, 1), all - 1);
  EXPECT_EQ(steady_frames(false, 0, 0), 1U);
}

TEST(LoopGap, ARestartIsAGap) {
  const auto depth = last_depth({}, [](Loop& loop) { loop.restart(timing()); });
  EXPECT_EQ(depth, without_past(kGap));
}

}  // namespace
}  // namespace stof::firmware::test
