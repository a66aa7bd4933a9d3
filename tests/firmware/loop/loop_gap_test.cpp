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

TEST(LoopGap, ARestartIsAGap) {
  const auto depth = last_depth({}, [](Loop& loop) { loop.restart(timing()); });
  EXPECT_EQ(depth, without_past(kGap));
}

}  // namespace
}  // namespace stof::firmware::test
