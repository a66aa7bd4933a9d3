#include <gtest/gtest.h>

#include "tests/firmware/rig.h"

// After a gap in the frames depth is averaged with none that came before it.
namespace stof::firmware::test {
namespace {

constexpr std::uint32_t kGap = 20;  // the edge that it begins with
constexpr int kSteps = 40;

// Depth of the last frame of a rig before which nothing moves, which is asked to `act` at kGap.
template <typename Act>
std::vector<std::uint16_t> last_depth(const Faults& faults, Act act) {
  Rig rig({.faults = faults, .still = true, .temporal = true});
  Receiver receiver;
  run(rig, receiver, kGap);
  act(rig.loop);
  run(rig, receiver, kSteps - kGap);
  EXPECT_FALSE(receiver.frames.empty());
  return receiver.frames.rbegin()->second.depth;
}

std::vector<std::uint16_t> last_depth(const Faults& faults) {
  return last_depth(faults, [](Loop&) {});
}

emu::Fault no_frame(std::uint32_t first, std::uint32_t edges) {
  return {.kind = emu::FaultKind::kDrop, .call = first, .calls = edges};
}

// Of a rig whose first frame is that of this edge.
std::vector<std::uint16_t> without_past(std::uint32_t first) {
  return last_depth({.stereo = {no_frame(0, first)}});
}

TEST(LoopGap, TheNoiseOfThisRigIsAveraged) { EXPECT_NE(last_depth({}), without_past(kGap)); }

TEST(LoopGap, ThreeEdgesWithoutAFrameAreAGapFewerAreNot) {
  EXPECT_EQ(last_depth({.stereo = {no_frame(kGap, 3)}}), without_past(kGap + 3));
  EXPECT_EQ(last_depth({.pmd = {no_frame(kGap, 3)}}), without_past(kGap + 3));
  EXPECT_EQ(last_depth({.stereo = {no_frame(kGap, 15)}}), without_past(kGap + 15));
  EXPECT_NE(last_depth({.stereo = {no_frame(kGap, 2)}}), without_past(kGap + 2));
}

TEST(LoopGap, ALostStereoCameraIsAGapHoweverSoonItIsBack) {
  const emu::Fault lost{.kind = emu::FaultKind::kVanish, .call = kGap};
  EXPECT_EQ(last_depth({.stereo = {lost}}), without_past(kGap + 1));
  EXPECT_NE(last_depth({.pmd = {lost}}), without_past(kGap + 1));
}

// Of the last frame of a rig whose first one is that of edge `first`.
std::uint32_t steady_frames(bool temporal, std::uint32_t first, std::uint32_t lost) {
  Rig rig({.faults = {.stereo = {no_frame(first, lost)}}, .still = true, .temporal = temporal});
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
