#include "board/devices/hotplug_camera.h"

#include <gtest/gtest.h>

#include "hal/stereo_camera.h"

namespace stof::board {
namespace {

// A camera whose next answer the test decides.
struct Script {
  bool there = false;
  int opened = 0;
  int reopened = 0;
  Status answer = Status::kTimeout;
};

class ScriptedCamera final : public hal::StereoCamera {
 public:
  explicit ScriptedCamera(Script& script) : script_(script) {}
  Result<hal::BorrowedFrame<hal::StereoFrame>> wait_frame(hal::Time) noexcept override {
    return fail(script_.answer);
  }

 private:
  Script& script_;
};

using HotplugStereo = HotplugCamera<hal::StereoCamera, hal::StereoFrame>;

HotplugStereo::Open opener(Script& script) {
  return [&script]() -> std::expected<HotplugStereo::Opened, hal::linux::OpenError> {
    if (!script.there) {
      return std::unexpected(hal::linux::OpenError{"no camera: plug it in"});
    }
    ++script.opened;
    return HotplugStereo::Opened{.camera = std::make_unique<ScriptedCamera>(script),
                                 .reopen = [&script] {
                                   ++script.reopened;
                                   return script.there ? Status::kOk : Status::kDeviceLost;
                                 }};
  };
}

Status answer(HotplugStereo& camera) { return camera.wait_frame(hal::Time{}).error(); }

TEST(HotplugCamera, IsLostUntilItsCameraComes) {
  Script script;
  HotplugStereo camera(opener(script));
  EXPECT_EQ(camera.why(), "no camera: plug it in");
  EXPECT_EQ(answer(camera), Status::kDeviceLost);
  EXPECT_EQ(camera.reopen(), Status::kDeviceLost);
  script.there = true;
  EXPECT_EQ(camera.reopen(), Status::kOk);
  EXPECT_EQ(answer(camera), Status::kTimeout);
  EXPECT_EQ(script.opened, 1);
  EXPECT_EQ(script.reopened, 0);
}

TEST(HotplugCamera, ReopensInPlaceWhetherLostOrNot) {
  Script script{.there = true};
  HotplugStereo camera(opener(script));
  EXPECT_EQ(camera.why(), "");
  EXPECT_EQ(camera.reopen(), Status::kOk);
  EXPECT_EQ(script.reopened, 1) << "it may repeat itself";
  EXPECT_EQ(answer(camera), Status::kTimeout);
  script.there = false;
  EXPECT_EQ(camera.reopen(), Status::kDeviceLost);
  script.answer = Status::kDeviceLost;
  EXPECT_EQ(answer(camera), Status::kDeviceLost);
  EXPECT_EQ(camera.reopen(), Status::kDeviceLost);
  EXPECT_EQ(answer(camera), Status::kDeviceLost);
  script.there = true;
  script.answer = Status::kTimeout;
  EXPECT_EQ(camera.reopen(), Status::kOk);
  EXPECT_EQ(answer(camera), Status::kTimeout);
  EXPECT_EQ(script.opened, 1);
  EXPECT_EQ(script.reopened, 4);
}

TEST(HotplugCamera, SilentCameraIsOpenedAnewAtLongerAndLongerIntervals) {
  Script script{.there = true};
  HotplugStereo camera(opener(script));
  std::vector<hal::Duration> when;
  for (hal::Duration at{}; at < std::chrono::minutes(5); at += std::chrono::milliseconds(33)) {
    if (camera.wait_frame(hal::Time(at)).error() == Status::kDeviceLost) {
      when.push_back(at);
      EXPECT_EQ(camera.reopen(), Status::kOk);
    }
  }
  ASSERT_GE(when.size(), 6U);
  EXPECT_NEAR(std::chrono::duration<double>(when[0]).count(), 3, 0.1);
  EXPECT_NEAR(std::chrono::duration<double>(when[1] - when[0]).count(), 6, 0.1);
  EXPECT_NEAR(std::chrono::duration<double>(when[5] - when[4]).count(), 60, 0.1);
  EXPECT_EQ(static_cast<std::size_t>(script.reopened), when.size());
}

}  // namespace
}  // namespace stof::board
