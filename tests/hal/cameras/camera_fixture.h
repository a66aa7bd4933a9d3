#pragma once

#include <gtest/gtest.h>

#include "dsp/base/status.h"
#include "hal/borrowed_frame.h"
#include "hal/clock.h"
#include "hal/time.h"

// A camera to be judged by camera_contract.h. A Rig is default constructible and has:
// - using Frame: hal::StereoFrame or hal::PmdFrame
// - static constexpr int kSlots: how many the camera has
// - hal::Clock& clock()
// - hal::Time pulse(): one good edge
// - Result<BorrowedFrame<Frame>> wait_frame(hal::Time)
// - hal::Duration frame_time(): from an edge until its frame is surely there
// - static std::vector<hal::Exposure> exposures(const Frame&)
// - static std::uint32_t sequence(const Frame&)
// - static std::vector<std::uint8_t> bytes(const Frame&): a copy of all pixels
namespace stof::test {

template <typename Rig>
class CameraContract : public testing::Test {
 protected:
  using Frame = typename Rig::Frame;

  // Waits until the frame of an edge is there, without reading it.
  void expose() {
    const hal::Time edge = rig_.pulse();
    rig_.clock().wait_until(edge + rig_.frame_time());
  }
  Result<hal::BorrowedFrame<Frame>> read() {
    return rig_.wait_frame(rig_.clock().now() + rig_.frame_time());
  }
  Result<hal::BorrowedFrame<Frame>> shoot() {
    rig_.pulse();
    return read();
  }

  Rig rig_;
};

}  // namespace stof::test
