#include <gtest/gtest.h>

#include "tests/hal/cameras/camera_contract.h"
#include "tests/hal/v4l2/v4l2_pmd_rig.h"
#include "tests/hal/v4l2/v4l2_rigs.h"

namespace stof::test {
namespace {

using hal::linux::kGrey;
using hal::linux::kY10;
using hal::linux::kY12;
using hal::linux::kY12p;
using hal::linux::kY16;
using hal::linux::kYuyv;

using Cameras = testing::Types<V4l2StereoRig<kGrey, false>, V4l2StereoRig<kY10, false>,
                               V4l2StereoRig<kGrey, true>, V4l2PmdRig<kY12p>>;
INSTANTIATE_TYPED_TEST_SUITE_P(V4l2, CameraContract, Cameras);

template <typename Rig>
class V4l2Formats : public testing::Test {};
using Formats =
    testing::Types<V4l2StereoRig<kGrey, false>, V4l2StereoRig<kGrey, false, 5>,
                   V4l2StereoRig<kY10, false>, V4l2StereoRig<kY12, false, 6>,
                   V4l2StereoRig<kY16, false>, V4l2StereoRig<kYuyv, false>,
                   V4l2StereoRig<kGrey, true>, V4l2StereoRig<kGrey, true, 3>,
                   V4l2StereoRig<kYuyv, true>, V4l2StereoRig<kY16, true, 1>, V4l2PmdRig<kY12p>,
                   V4l2PmdRig<kY12p, 4>, V4l2PmdRig<kY12>, V4l2PmdRig<kY16, 2>>;
TYPED_TEST_SUITE(V4l2Formats, Formats);

TYPED_TEST(V4l2Formats, GivesTheBrightnessOfEveryPixel) {
  TypeParam rig;
  for (std::uint32_t number = 1; number <= 6; ++number) {
    const auto frame = rig.shoot();
    ASSERT_TRUE(frame);
    EXPECT_EQ(TypeParam::bytes(**frame), TypeParam::expected(number)) << "exposure " << number;
  }
}

TYPED_TEST(V4l2Formats, LentFramesStayReadableWhenTheDeviceIsLostAndBack) {
  TypeParam rig;
  {
    const auto before = rig.shoot();
    ASSERT_TRUE(before);
    ASSERT_EQ(rig.camera().reopen(), Status::kOk) << "a frame that is lent makes it busy";
    const auto after = rig.shoot();
    ASSERT_TRUE(after);
    EXPECT_EQ(TypeParam::bytes(**before), TypeParam::expected(1));
    EXPECT_EQ(TypeParam::bytes(**after), TypeParam::expected(2));
  }
  for (std::uint32_t number = 3; number < 20; ++number) {
    const auto frame = rig.shoot();
    ASSERT_TRUE(frame);
    EXPECT_EQ(TypeParam::bytes(**frame), TypeParam::expected(number));
  }
  rig.close();
  EXPECT_EQ(rig.kernel().mappings(), 0U);
  EXPECT_EQ(rig.kernel().open_files(), 0);
}

TYPED_TEST(V4l2Formats, SignalsChangeNothing) {
  TypeParam rig;
  rig.kernel().interrupt();
  for (std::uint32_t number = 1; number <= 3; ++number) {
    const auto frame = rig.shoot();
    ASSERT_TRUE(frame);
    EXPECT_EQ(TypeParam::bytes(**frame), TypeParam::expected(number));
  }
  EXPECT_EQ(rig.camera().reopen(), Status::kOk);
}

}  // namespace
}  // namespace stof::test
