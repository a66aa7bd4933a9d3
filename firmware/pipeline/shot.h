#pragma once

#include <cstdint>
#include <optional>

#include "hal/borrowed_frame.h"
#include "hal/pmd_camera.h"
#include "hal/stereo_camera.h"
#include "hal/time.h"

namespace stof::firmware {

// The verified frames of all cameras for one trigger edge. The slots go home with it.
struct Shot {
  hal::Time edge;
  hal::Time exposed;  // middle of the exposure of the left view
  hal::BorrowedFrame<hal::StereoFrame> stereo;
  // New samples; without them those of before hold.
  std::optional<hal::BorrowedFrame<hal::PmdFrame>> pmd;
  std::optional<hal::Time> pmd_exposed;  // middle of the PMD data in use; none: no PMD camera
  std::uint32_t freshness = 0;           // advances with each verified new exposure of the pair
  std::uint32_t missed_edges = 0;        // without a frame, since the last with one
  std::uint64_t stereo_losses = 0;       // of the camera, so far
};

}  // namespace stof::firmware
