#pragma once

#include <cstdint>
#include <optional>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "dsp/calib/pinhole.h"
#include "dsp/fusion/drift/drift_monitor.h"
#include "dsp/fusion/drift/picture_shift.h"

namespace stof::dsp {

// What a rig did between the middles of two exposures.
struct Moved {
  // It turned by so much, radians, as DriftParameter::kPitch and kYaw count it.
  double pitch = 0;
  double yaw = 0;
  // Standard deviations that what is not known of it gives each drift.
  DriftVector unsure{};
  bool moved = false;
};

// How a rig turns, from what the left picture's content moves by from frame to frame. What it
// drives is not known, nor is a turn about its axis, which no vehicle goes on with.
class RigMotion {
 public:
  RigMotion() noexcept = default;
  // Pictures of the size of `left`.
  RigMotion(const Pinhole& left, Arena& arena) noexcept;

  // The left picture of each pair. since_us: from the middle of the exposure of the pair before it,
  // microseconds; 0: not known. Of another size it says nothing.
  void follow(ImageView<const std::uint8_t> picture, std::int32_t since_us) noexcept;
  void forget() noexcept;

  // In the lag_us after the last picture. something_moves: whatever the picture says. Nothing where
  // it turned too far, or nobody knows how far. Without a lag it did not turn.
  std::optional<Moved> during(std::int32_t lag_us, bool something_moves) const noexcept;

 private:
  Pinhole left_;
  PictureShift shift_;
  std::optional<Shift> rate_;  // px a microsecond, of the last picture
};

}  // namespace stof::dsp
