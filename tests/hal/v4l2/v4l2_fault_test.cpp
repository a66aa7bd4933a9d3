#include <ctime>

#include <gtest/gtest.h>

#include "hal/linux/system/clock_offset.h"
#include "tests/hal/v4l2/v4l2_pmd_rig.h"
#include "tests/hal/v4l2/v4l2_rigs.h"

namespace stof::test {
namespace {

using namespace std::chrono_literals;
using Stereo = V4l2StereoRig<hal::linux::kGrey, false>;
using Pmd = V4l2PmdRig<hal::linux::kY12p>;

// Frames of whole pairs: both views of one exposure, as it says.
void expect_exposure(const Result<hal::BorrowedFrame<hal::StereoFrame>>& frame,
                     std::uint32_t number) {
  ASSERT_TRUE(frame) << to_string(frame.error());
  EXPECT_EQ(Stereo::bytes(**frame), Stereo::expected(number)) << "exposure " << number;
  EXPECT_EQ((*frame)->left_exposure.begin, (*frame)->right_exposure.begin);
}

TEST(V4l2Stereo, PictureThatIsLostCostsOneFrameAndNeverShiftsTheViews) {
  for (const std::size_t side : {0U, 1U}) {
    Stereo rig;
    rig.fake(side).faults[2] = V4l2Fault::kLose;
    expect_exposure(rig.shoot(), 1);
    const auto lost = rig.shoot();
    ASSERT_FALSE(lost);
    EXPECT_EQ(lost.error(), Status::kTimeout);
    for (std::uint32_t number = 3; number <= 12; ++number) {
      expect_exposure(rig.shoot(), number);
    }
    EXPECT_EQ(rig.camera().counters().unpaired, 1U);
    EXPECT_EQ(rig.camera().counters().frames, 12U) << "with the one that was not believed";
  }
}

TEST(V4l2Stereo, ManyLostPicturesOnOneSideDoNotStopTheOther) {
  Stereo rig;
  for (std::uint32_t number = 2; number <= 30; ++number) {
    rig.fake(0).faults[number] = V4l2Fault::kLose;
  }
  expect_exposure(rig.shoot(), 1);
  for (int i = 2; i <= 30; ++i) {
    EXPECT_FALSE(rig.shoot());
  }
  for (std::uint32_t number = 31; number <= 40; ++number) {
    expect_exposure(rig.shoot(), number);
  }
}

TEST(V4l2Stereo, LatePictureCostsOneFrame) {
  Stereo rig;
  rig.fake(1).faults[2] = V4l2Fault::kLate;
  expect_exposure(rig.shoot(), 1);
  EXPECT_FALSE(rig.shoot());
  rig.clock().wait_until(rig.clock().now() + 200ms);
  for (std::uint32_t number = 3; number <= 8; ++number) {
    expect_exposure(rig.shoot(), number);
  }
  EXPECT_EQ(rig.camera().counters().unmatched, 1U);
}

TEST(V4l2Stereo, PicturesWithoutAnExposureCarryTheirRawStamps) {
  Stereo rig;
  rig.fake(0).faults[1] = V4l2Fault::kLate;
  rig.fake(1).faults[1] = V4l2Fault::kLate;
  const hal::Time edge = rig.pulse();
  const auto frame = rig.wait_frame(edge + 1s);
  ASSERT_TRUE(frame);
  for (const hal::Exposure& exposure : Stereo::exposures(**frame)) {
    EXPECT_EQ(exposure.begin, edge + Stereo::kExposure + Stereo::kReadout + 100ms);
    EXPECT_EQ(exposure.end, exposure.begin);
  }
}

TEST(V4l2Stereo, StampsOfTheWallClockAreConverted) {
  Stereo rig;
  const hal::linux::ClockOffset wall(CLOCK_REALTIME);
  for (const std::size_t side : {0U, 1U}) {
    rig.fake(side).stamps_ahead = wall.from_monotonic(hal::Time{});
  }
  for (std::uint32_t number = 1; number <= 5; ++number) {
    const hal::Time edge = rig.clock().now();
    const auto frame = rig.shoot();
    expect_exposure(frame, number);
    EXPECT_EQ((*frame)->left_exposure.begin, edge);
  }
}

TEST(V4l2Stereo, FrameThatWaitedCarriesItsTrueExposure) {
  Stereo rig;
  const hal::Time edge = rig.pulse();
  rig.clock().wait_until(edge + 33ms);
  rig.pulse();
  const auto frame = rig.wait_frame(rig.clock().now() + 3ms);
  expect_exposure(frame, 1);
  EXPECT_EQ((*frame)->left_exposure.begin, edge);
  expect_exposure(rig.wait_frame(rig.clock().now() + 3ms), 2);
}

TEST(V4l2Stereo, DamagedPicturesAreToldOncePerExposure) {
  for (const V4l2Fault fault : {V4l2Fault::kErrorFlag, V4l2Fault::kShort}) {
    Stereo rig;
    rig.fake(0).faults[2] = fault;
    rig.fake(1).faults[2] = fault;
    rig.fake(1).faults[4] = fault;
    expect_exposure(rig.shoot(), 1);
    EXPECT_EQ(rig.shoot().error(), Status::kCorrupt);
    expect_exposure(rig.shoot(), 3);
    EXPECT_EQ(rig.shoot().error(), Status::kCorrupt);
    for (std::uint32_t number = 5; number <= 30; ++number) {
      expect_exposure(rig.shoot(), number);
    }
    EXPECT_EQ(rig.camera().counters().devices[0].damaged, 1U);
    EXPECT_EQ(rig.camera().counters().devices[1].damaged, 2U);
  }
}

TEST(V4l2Stereo, CameraThatAlwaysHasOneMoreDoesNotHoldUpTheDeadline) {
  for (const std::size_t side : {0U, 1U}) {
    Stereo rig;
    rig.fake(side).chatty = true;
    const hal::Time deadline = rig.clock().now() + 5ms;
    // Pictures without edges: nobody can place them, and after a while the camera is given up.
    EXPECT_FALSE(rig.wait_frame(deadline));
    EXPECT_LT(rig.clock().now(), deadline + 1ms);
  }
}

TEST(V4l2Stereo, WaitsInTheKernelAndNotInALoop) {
  Stereo rig;
  EXPECT_FALSE(rig.wait_frame(rig.clock().now() + 10s));
  EXPECT_LE(rig.kernel().polls(), 2);
}

TEST(V4l2Stereo, FewErrorsOfTheDriverAreCountedManyAreALoss) {
  Stereo rig;
  rig.fake(0).errors = 5;
  expect_exposure(rig.shoot(), 1);
  EXPECT_EQ(rig.camera().counters().devices[0].io_errors, 5U);
  rig.fake(0).errors = 1000;
  EXPECT_EQ(rig.shoot().error(), Status::kDeviceLost);
  rig.fake(0).errors = 0;
  EXPECT_EQ(rig.shoot().error(), Status::kDeviceLost) << "until it is opened anew";
  EXPECT_EQ(rig.camera().reopen(), Status::kOk);
  EXPECT_TRUE(rig.shoot());
}

TEST(V4l2Stereo, LostDeviceComesBackWithFramesLent) {
  Stereo rig;
  {
    const auto first = rig.shoot();
    const auto second = rig.shoot();
    rig.kernel().unplug(rig.fake(1));
    const hal::Time before = rig.clock().now();
    EXPECT_EQ(rig.wait_frame(before + 1s).error(), Status::kDeviceLost);
    EXPECT_EQ(rig.clock().now(), before);
    EXPECT_EQ(rig.camera().reopen(), Status::kDeviceLost);
    EXPECT_EQ(rig.wait_frame(before + 1s).error(), Status::kDeviceLost);
    rig.kernel().plug(rig.fake(1), "/dev/video2");
    ASSERT_EQ(rig.camera().reopen(), Status::kOk);
    expect_exposure(first, 1);
    expect_exposure(second, 2);
    EXPECT_TRUE(rig.shoot());
    EXPECT_TRUE(rig.shoot());
  }
  rig.close();
  EXPECT_EQ(rig.kernel().mappings(), 0U);
  EXPECT_EQ(rig.kernel().open_files(), 0);
}

TEST(V4l2Stereo, IsLostWhileItWaits) {
  Stereo rig;
  rig.pulse();
  EXPECT_TRUE(rig.wait_frame(rig.clock().now() + 3ms));
  rig.kernel().unplug(rig.fake(0));
  EXPECT_EQ(rig.wait_frame(rig.clock().now() + 3ms).error(), Status::kDeviceLost);
}

TEST(V4l2Stereo, ReopeningManyTimesKeepsNothing) {
  Stereo rig;
  std::optional<hal::BorrowedFrame<hal::StereoFrame>> held;
  for (std::uint32_t number = 1; number <= 20; ++number) {
    auto frame = rig.shoot();
    expect_exposure(frame, number);
    held.reset();
    held.emplace(std::move(*frame));
    ASSERT_EQ(rig.camera().reopen(), Status::kOk);
    EXPECT_EQ(Stereo::bytes(**held), Stereo::expected(number));
  }
  held.reset();
  rig.close();
  EXPECT_EQ(rig.kernel().mappings(), 0U);
}

TEST(V4l2Stereo, CopiesGreyWhereItIsAsked) {
  V4l2StereoRig<hal::linux::kGrey, false, 5> rig;
  rig.close();
  auto options = rig.options();
  options.copy = true;
  const auto camera = hal::linux::V4l2Stereo::open(rig.kernel(), rig.clock(), options);
  ASSERT_TRUE(camera);
  const hal::Time edge = rig.pulse();
  const auto frame = (*camera)->wait_frame(edge + 3ms);
  expect_exposure(frame, 1);
  EXPECT_EQ((*frame)->left.stride(), (*frame)->left.width());
}

TEST(V4l2Pmd, SamplesCarryTheQuartersOfTheExposure) {
  Pmd rig;
  const hal::Time edge = rig.pulse();
  const auto frame = rig.wait_frame(edge + 3ms);
  ASSERT_TRUE(frame);
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ((*frame)->exposures[static_cast<std::size_t>(k)].begin, edge + k * 200us);
    EXPECT_EQ((*frame)->exposures[static_cast<std::size_t>(k)].end, edge + (k + 1) * 200us);
  }
}

TEST(V4l2Pmd, IntegrationMayBeShorterThanTheExposure) {
  Pmd rig;
  rig.close();
  auto options = rig.options();
  options.integration = 400us;
  const auto camera = hal::linux::V4l2Pmd::open(rig.kernel(), rig.clock(), options);
  ASSERT_TRUE(camera);
  ASSERT_TRUE((*camera)->wait_frame(rig.pulse() + 3ms)) << "not believed, but told";
  rig.clock().wait_until(rig.clock().now() + 3ms);
  const hal::Time edge = rig.pulse();
  const auto frame = (*camera)->wait_frame(edge + 3ms);
  ASSERT_TRUE(frame);
  EXPECT_EQ((*frame)->exposures[3].begin, edge + 300us);
  EXPECT_EQ((*frame)->exposures[3].end, edge + 400us);
}

TEST(V4l2Pmd, DamagedLostAndLateFramesCostThemselvesAlone) {
  Pmd rig;
  rig.fake().faults = {{2, V4l2Fault::kErrorFlag},
                       {3, V4l2Fault::kShort},
                       {4, V4l2Fault::kLose},
                       {6, V4l2Fault::kLate}};
  EXPECT_TRUE(rig.shoot());
  EXPECT_EQ(rig.shoot().error(), Status::kCorrupt);
  EXPECT_EQ(rig.shoot().error(), Status::kCorrupt);
  EXPECT_EQ(rig.shoot().error(), Status::kTimeout);
  const auto fifth = rig.shoot();
  ASSERT_TRUE(fifth);
  EXPECT_EQ((*fifth)->sequence, 5U);
  EXPECT_EQ(Pmd::bytes(**fifth), Pmd::expected(5));
  EXPECT_EQ(rig.shoot().error(), Status::kTimeout);
  const auto late = rig.wait_frame(rig.clock().now() + 200ms);
  ASSERT_TRUE(late);
  EXPECT_EQ((*late)->exposures[0].begin, (*late)->exposures[3].end);
}

TEST(V4l2Pmd, ComesBackAfterItWasLost) {
  Pmd rig;
  const auto held = rig.shoot();
  rig.kernel().unplug(rig.fake());
  EXPECT_EQ(rig.shoot().error(), Status::kDeviceLost);
  EXPECT_EQ(rig.camera().reopen(), Status::kDeviceLost);
  rig.kernel().plug(rig.fake(), "/dev/video0");
  EXPECT_EQ(rig.camera().reopen(), Status::kOk);
  EXPECT_TRUE(rig.shoot());
  EXPECT_EQ(Pmd::bytes(**held), Pmd::expected(1));
}

}  // namespace
}  // namespace stof::test
