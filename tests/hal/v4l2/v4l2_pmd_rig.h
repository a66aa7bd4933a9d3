#pragma once

#include "tests/hal/v4l2/v4l2_rigs.h"

namespace stof::test {

// A PMD camera of a FakeV4l2, as camera_contract.h wants it.
template <hal::linux::FourCc kFormat, std::uint32_t kPadding = 0>
class V4l2PmdRig : public V4l2Rig {
 public:
  using Frame = hal::PmdFrame;
  using Camera = hal::linux::V4l2Pmd;
  static constexpr int kSlots = Camera::kSlots;

  V4l2PmdRig() {
    FakeCamera camera{.path = "/dev/video0"};
    camera.formats = {kFormat};
    camera.height = 4 * kHeight;
    camera.padding = kPadding;
    camera.pixel = [](std::uint32_t number, int x, int y) {
      return sample(number, y / kHeight, x, y % kHeight);
    };
    fake_ = &kernel_.add(std::move(camera));
    auto opened = Camera::open(kernel_, clock_, options());
    EXPECT_TRUE(opened) << opened.error().message;
    camera_ = std::move(*opened);
    // The first picture after opening is not believed.
    static_cast<void>(shoot());
    clock_.wait_until(clock_.now() + frame_time());
    kernel_.count_anew();
  }

  hal::linux::V4l2PmdOptions options() {
    return {.node = "/dev/video0", .width = kWidth, .height = kHeight, .exposures = &exposures_};
  }
  Camera& camera() { return *camera_; }
  FakeCamera& fake() { return *fake_; }
  void close() { camera_.reset(); }
  auto wait_frame(hal::Time deadline) { return camera_->wait_frame(deadline); }
  auto shoot() {
    pulse();
    return wait_frame(clock_.now() + frame_time());
  }

  // 12 bits.
  static std::uint32_t sample(std::uint32_t number, int k, int x, int y) {
    return (number * 257 + static_cast<std::uint32_t>(k * 1009 + x * 131 + y * 17)) & 0xFFF;
  }
  static std::vector<hal::Exposure> exposures(const Frame& frame) {
    return {frame.exposures.begin(), frame.exposures.end()};
  }
  static std::uint32_t sequence(const Frame& frame) { return frame.sequence; }
  static std::vector<std::uint8_t> bytes(const Frame& frame) {
    std::vector<std::uint8_t> out;
    for (const auto& view : frame.samples) {
      append_bytes(view, out);
    }
    return out;
  }
  // What bytes() gives for that exposure.
  static std::vector<std::uint8_t> expected(std::uint32_t number) {
    std::vector<std::uint8_t> out;
    for (int i = 0; i < 4 * kWidth * kHeight; ++i) {
      const int y = i / kWidth;
      const std::uint32_t value = sample(number, y / kHeight, i % kWidth, y % kHeight);
      out.push_back(static_cast<std::uint8_t>(value & 0xFF));
      out.push_back(static_cast<std::uint8_t>(value >> 8));
    }
    return out;
  }

 private:
  FakeCamera* fake_ = nullptr;
  std::unique_ptr<Camera> camera_;
};

}  // namespace stof::test
