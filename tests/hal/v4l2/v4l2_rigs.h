#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "hal/emu/devices/clock.h"
#include "hal/linux/camera/exposures.h"
#include "hal/linux/v4l2/v4l2_pmd.h"
#include "hal/linux/v4l2/v4l2_stereo.h"
#include "tests/hal/cameras/emu_cameras.h"
#include "tests/hal/v4l2/v4l2_fake.h"

namespace stof::test {

// Cameras of a FakeV4l2 on a trigger, as camera_contract.h wants them.
class V4l2Rig {
 public:
  static constexpr int kWidth = 8;
  static constexpr int kHeight = 4;
  static constexpr hal::Duration kExposure = std::chrono::microseconds(800);
  static constexpr hal::Duration kReadout = std::chrono::microseconds(200);

  hal::Clock& clock() { return clock_; }
  FakeV4l2& kernel() { return kernel_; }
  hal::Time pulse() {
    const hal::Time edge = clock_.now();
    edges_.note(edge);
    kernel_.expose(edge, kExposure, kReadout);
    return edge;
  }
  static hal::Duration frame_time() { return std::chrono::milliseconds(3); }

 protected:
  // 8 bits, of exposure `number` of a view.
  static std::uint32_t grey(int side, std::uint32_t number, int x, int y) {
    return (number * 7 + static_cast<std::uint32_t>(side * 101 + x * 3 + y * 17)) & 0xFF;
  }

  hal::emu::Clock clock_;
  FakeV4l2 kernel_{clock_};
  hal::linux::EdgeLog edges_;
  hal::linux::EdgeExposures exposures_{edges_, kExposure};
};

// The brightness of a pixel with a format's bits, low ones set that conversion has to drop.
inline std::uint32_t deepen(hal::linux::FourCc format, std::uint32_t grey) {
  switch (format) {
    case hal::linux::kY10:
      return grey << 2 | 3;
    case hal::linux::kY12:
      return grey << 4 | 15;
    case hal::linux::kY16:
      return grey << 8 | 255;
    default:
      return grey;
  }
}

template <hal::linux::FourCc kFormat, bool kSideBySide, std::uint32_t kPadding = 0>
class V4l2StereoRig : public V4l2Rig {
 public:
  using Frame = hal::StereoFrame;
  using Camera = hal::linux::V4l2Stereo;
  static constexpr int kSlots = Camera::kSlots;

  V4l2StereoRig() {
    for (int side = 0; side < (kSideBySide ? 1 : 2); ++side) {
      FakeCamera camera{.path = "/dev/video" + std::to_string(2 * side)};
      camera.formats = {hal::linux::fourcc("MJPG"), kFormat};
      camera.width = kSideBySide ? 2 * kWidth : kWidth;
      camera.padding = kPadding;
      camera.controls[V4L2_CID_EXPOSURE_AUTO] = {.maximum = 3, .value = 3};
      camera.controls[V4L2_CID_EXPOSURE_AUTO_PRIORITY] = {.maximum = 1, .value = 1};
      camera.controls[V4L2_CID_EXPOSURE_ABSOLUTE] = {.minimum = 1, .maximum = 5000};
      camera.controls[V4L2_CID_GAIN] = {.maximum = 100};
      camera.pixel = [side](std::uint32_t number, int x, int y) {
        const bool right = kSideBySide && x >= kWidth;
        return deepen(kFormat, grey(right ? 1 : side, number, right ? x - kWidth : x, y));
      };
      cameras_.push_back(&kernel_.add(std::move(camera)));
    }
    auto opened = Camera::open(kernel_, clock_, options());
    EXPECT_TRUE(opened) << opened.error().message;
    camera_ = std::move(*opened);
    believe();
  }
  // The first picture after opening is not believed.
  void believe() {
    static_cast<void>(shoot());
    clock_.wait_until(clock_.now() + frame_time());
    kernel_.count_anew();
  }

  hal::linux::V4l2StereoOptions options() {
    return {.nodes = {"/dev/video0", kSideBySide ? "" : "/dev/video2"},
            .width = kWidth,
            .height = kHeight,
            .exposure = kExposure,
            .gain = 7,
            .exposures = {&exposures_, &exposures_}};
  }
  Camera& camera() { return *camera_; }
  FakeCamera& fake(std::size_t side) { return *cameras_[side]; }
  void close() { camera_.reset(); }
  auto wait_frame(hal::Time deadline) { return camera_->wait_frame(deadline); }
  auto shoot() {
    pulse();
    return wait_frame(clock_.now() + frame_time());
  }

  static std::vector<hal::Exposure> exposures(const Frame& frame) {
    return {frame.left_exposure, frame.right_exposure};
  }
  static std::uint32_t sequence(const Frame& frame) { return frame.left_sequence; }
  static std::vector<std::uint8_t> bytes(const Frame& frame) {
    std::vector<std::uint8_t> out;
    append_bytes(frame.left, out);
    append_bytes(frame.right, out);
    return out;
  }
  // What bytes() gives for that exposure.
  static std::vector<std::uint8_t> expected(std::uint32_t number) {
    std::vector<std::uint8_t> out;
    for (int side = 0; side < 2; ++side) {
      for (int i = 0; i < kWidth * kHeight; ++i) {
        out.push_back(static_cast<std::uint8_t>(grey(side, number, i % kWidth, i / kWidth)));
      }
    }
    return out;
  }

 private:
  std::vector<FakeCamera*> cameras_;
  std::unique_ptr<Camera> camera_;
};

}  // namespace stof::test
