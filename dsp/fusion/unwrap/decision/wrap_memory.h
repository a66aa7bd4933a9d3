#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/fusion/unwrap/wrap_maps.h"

namespace stof::dsp {

// Wrap counts of earlier frames of a standing camera. A count is a decision by votes and limits, so
// near a limit it is there in some frames and not in others. What was decided more often than not
// is kept where this frame decides nothing, for a reading that is the same as before: within 3
// sigma and a 64th. A count that differs from what was mostly decided is not believed until it has
// more votes. Nothing is kept that this frame's amplitude or stereo exclude.
class WrapMemory {
 public:
  // A decision counts as much as kDecided frames without one.
  static constexpr int kDecided = 2;
  static constexpr int kEnough = 4;  // of that: what is kept
  static constexpr int kMost = 8;

  WrapMemory(std::size_t pixels, Arena& arena) noexcept;

  void forget() noexcept;
  // After WrapDecision::decide(): changes wraps of the maps, and remembers.
  void steady(const WrapMaps& maps) noexcept;

 private:
  std::span<QuarterMm> distance_;  // of the reading last seen, as if it had not wrapped
  std::span<std::int8_t> wraps_;
  std::span<std::uint8_t> votes_;  // 0: nothing is known
};

}  // namespace stof::dsp
