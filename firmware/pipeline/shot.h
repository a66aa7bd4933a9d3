#pragma once

#include <cstdint>
#include <optional>

#include "firmware/wire/frame_info.h"
#include "hal/borrowed_frame.h"
#include "hal/pmd_camera.h"
#include "hal/stereo_camera.h"
#include "hal/time.h"

namespace stof::firmware {

using wire::kBothSensors;
using wire::kNoSensor;
using wire::kPmdSensor;
using wire::kStereoSensor;
using wire::Sensors;

// The verified frames of one trigger edge: of both sensors, or of the one that there is. The slots
// go home with it.
struct Shot {
  hal::Time edge;     // that it was collected at
  hal::Time exposed;  // middle of the exposure of the left view; without a pair, of the samples
  std::optional<hal::BorrowedFrame<hal::StereoFrame>> stereo;
  // New samples; without them those of before hold.
  std::optional<hal::BorrowedFrame<hal::PmdFrame>> pmd;
  std::optional<hal::Time> pmd_exposed;  // middle of the PMD data in use; none: there are none
  std::uint32_t freshness = 0;           // advances with each shot: each has a new exposure
  std::uint32_t missed_edges = 0;        // without a frame, since the last with one
  std::uint64_t stereo_losses = 0;       // of the camera, so far
  // What it was computed with: RawInfo::state, of this shot alone. Told once that is known.
  std::uint8_t state = 0;

  Sensors sensors() const noexcept {
    return static_cast<Sensors>((stereo ? kStereoSensor : kNoSensor) |
                                (pmd_exposed ? kPmdSensor : kNoSensor));
  }
};

}  // namespace stof::firmware
