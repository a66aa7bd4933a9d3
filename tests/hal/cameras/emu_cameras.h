#pragma once

#include <cstdint>
#include <vector>

#include "hal/emu/cameras/pmd_camera.h"
#include "hal/emu/cameras/stereo_camera.h"
#include "hal/emu/cameras/trigger.h"
#include "hal/emu/devices/clock.h"
#include "tests/hal/imagery/fake_imagery.h"

namespace stof::test {

// One emulated camera on a trigger, as camera_contract.h wants it, on any clock.
template <typename Clock, typename Camera, typename CameraTiming>
class EmuRig {
 public:
  static constexpr int kSlots = hal::emu::kCameraSlots;
  static constexpr hal::Duration kPulse = std::chrono::microseconds(100);

  explicit EmuRig(const hal::emu::FaultPlan& camera_faults = {},
                  const hal::emu::FaultPlan& trigger_faults = {},
                  const CameraTiming& timing = quick())
      : camera_(clock_, imagery_, timing, camera_faults),
        trigger_(clock_, kPulse, {&camera_}, trigger_faults) {}

  hal::Clock& clock() { return clock_; }
  hal::Trigger& trigger() { return trigger_; }
  Camera& camera() { return camera_; }
  hal::Time pulse() { return trigger_.pulse().value_or(hal::Time{}); }
  auto wait_frame(hal::Time deadline) { return camera_.wait_frame(deadline); }
  hal::Duration frame_time() { return std::chrono::milliseconds(3); }

 protected:
  static CameraTiming quick() {
    CameraTiming timing;
    if constexpr (requires { timing.exposure; }) {
      timing.exposure = std::chrono::microseconds(800);
    } else {
      timing.integration = std::chrono::microseconds(800);
    }
    timing.readout = std::chrono::microseconds(200);
    return timing;
  }

 private:
  Clock clock_;
  FakeImagery imagery_;
  Camera camera_;
  hal::emu::Trigger trigger_;
};

template <typename T>
void append_bytes(dsp::ImageView<const T> image, std::vector<std::uint8_t>& out) {
  for (int y = 0; y < image.height(); ++y) {
    for (const T pixel : image.row(y)) {
      for (std::size_t i = 0; i < sizeof(T); ++i) {
        out.push_back(static_cast<std::uint8_t>(pixel >> (8 * i)));
      }
    }
  }
}

template <typename Clock>
class StereoRig : public EmuRig<Clock, hal::emu::StereoCamera, hal::emu::StereoTiming> {
 public:
  using Frame = hal::StereoFrame;
  using EmuRig<Clock, hal::emu::StereoCamera, hal::emu::StereoTiming>::EmuRig;
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
};

template <typename Clock>
class PmdRig : public EmuRig<Clock, hal::emu::PmdCamera, hal::emu::PmdTiming> {
 public:
  using Frame = hal::PmdFrame;
  using EmuRig<Clock, hal::emu::PmdCamera, hal::emu::PmdTiming>::EmuRig;
  static std::vector<hal::Exposure> exposures(const Frame& frame) {
    return {frame.exposures.begin(), frame.exposures.end()};
  }
  static std::uint32_t sequence(const Frame& frame) { return frame.sequence; }
  static std::vector<std::uint8_t> bytes(const Frame& frame) {
    std::vector<std::uint8_t> out;
    for (const auto& sample : frame.samples) {
      append_bytes(sample, out);
    }
    return out;
  }
};

}  // namespace stof::test
