#include <gtest/gtest.h>

#include "hal/linux/system/clock.h"
#include "tests/hal/cameras/camera_contract.h"
#include "tests/hal/cameras/emu_cameras.h"

namespace stof::test {
namespace {

using namespace std::chrono_literals;
using EmuStereo = StereoRig<hal::emu::Clock>;
using EmuPmd = PmdRig<hal::emu::Clock>;

using Cameras =
    testing::Types<EmuStereo, EmuPmd, StereoRig<hal::linux::Clock>, PmdRig<hal::linux::Clock>>;
INSTANTIATE_TYPED_TEST_SUITE_P(Emu, CameraContract, Cameras);

constexpr hal::Time kLate = hal::emu::Clock::kStart + 1h;

TEST(EmuStereoCamera, ExposesFromTheEdgeOnAndArrivesAfterReadout) {
  EmuStereo rig({}, {}, {.exposure = 4ms, .readout = 6ms});
  const hal::Time edge = rig.pulse();
  const auto frame = rig.wait_frame(kLate);
  ASSERT_TRUE(frame);
  EXPECT_EQ(rig.clock().now(), edge + 10ms);
  for (const hal::Exposure& exposure : EmuStereo::exposures(**frame)) {
    EXPECT_EQ(exposure.begin, edge);
    EXPECT_EQ(exposure.end, edge + 4ms);
  }
}

TEST(EmuStereoCamera, FrameThatIsNotYetThereIsATimeoutAndComesLater) {
  EmuStereo rig({}, {}, {.exposure = 4ms, .readout = 6ms});
  const hal::Time edge = rig.pulse();
  const auto early = rig.wait_frame(edge + 10ms - 1ns);
  ASSERT_FALSE(early);
  EXPECT_EQ(early.error(), Status::kTimeout);
  EXPECT_EQ(rig.clock().now(), edge + 10ms - 1ns);
  EXPECT_TRUE(rig.wait_frame(edge + 10ms));
}

TEST(EmuStereoCamera, ShowsTheExposureItNames) {
  EmuStereo rig;
  for (std::uint32_t number = 1; number <= 3; ++number) {
    rig.pulse();
    const auto frame = rig.wait_frame(kLate);
    ASSERT_TRUE(frame);
    const hal::StereoFrame& view = **frame;
    EXPECT_EQ(view.left_sequence, number);
    EXPECT_EQ(view.right_sequence, number);
    EXPECT_EQ(view.left.width(), FakeImagery::kStereo.width);
    EXPECT_EQ(view.right.height(), FakeImagery::kStereo.height);
    EXPECT_EQ(view.left.at(6, 2), FakeImagery::left_value(number));
    EXPECT_EQ(view.right.at(0, 0), FakeImagery::right_value(number));
  }
}

TEST(EmuStereoCamera, EdgeDuringAnExposureIsIgnored) {
  EmuStereo rig({}, {}, {.exposure = 4ms, .readout = 1ms});
  const hal::Time edge = rig.pulse();
  rig.clock().wait_until(edge + 2ms);
  rig.pulse();
  EXPECT_TRUE(rig.wait_frame(kLate));
  EXPECT_FALSE(rig.wait_frame(rig.clock().now() + 1s));
}

TEST(EmuPmdCamera, TakesTheFourSamplesOneAfterTheOther) {
  EmuPmd rig({}, {}, {.integration = 16ms, .readout = 4ms});
  const hal::Time edge = rig.pulse();
  const auto frame = rig.wait_frame(kLate);
  ASSERT_TRUE(frame);
  EXPECT_EQ(rig.clock().now(), edge + 20ms);
  for (int k = 0; k < 4; ++k) {
    const std::size_t i = static_cast<std::size_t>(k);
    EXPECT_EQ((*frame)->exposures[i].begin, edge + k * 4ms);
    EXPECT_EQ((*frame)->exposures[i].end, edge + (k + 1) * 4ms);
    EXPECT_EQ((*frame)->samples[i].at(4, 1), FakeImagery::pmd_value(1, k));
  }
}

TEST(EmuPmdCamera, ExposesAtEveryThirdEdge) {
  EmuPmd rig({}, {}, {.integration = 16ms, .readout = 4ms, .every = 3});
  for (int edge = 0; edge < 9; ++edge) {
    rig.pulse();
    const auto frame = rig.wait_frame(rig.clock().now() + 33ms);
    EXPECT_EQ(frame.has_value(), edge % 3 == 0) << "edge " << edge;
    if (frame) {
      EXPECT_EQ((*frame)->sequence, static_cast<std::uint32_t>(edge / 3 + 1));
    }
  }
}

}  // namespace
}  // namespace stof::test
