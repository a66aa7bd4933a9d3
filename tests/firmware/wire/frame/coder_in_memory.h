#pragma once

#include <cstddef>

#include "firmware/wire/frame/frame_coder.h"
#include "tests/support/guarded_part.h"

namespace stof::test {

// A frame's coder with memory for so many datagrams at a time; for all of them where it is not
// said how many.
class CoderInMemory : public GuardedPart<wire::FrameCoder> {
 public:
  CoderInMemory(const wire::Origin& origin, const wire::FrameSizes& sizes,
                const wire::CalibrationPacket& calibration, std::size_t packets)
      : GuardedPart([&](dsp::Arena& arena) noexcept {
          return wire::FrameCoder(origin, sizes, calibration, arena, packets);
        }) {}
  CoderInMemory(const wire::Origin& origin, const wire::FrameSizes& sizes,
                const wire::CalibrationPacket& calibration)
      : CoderInMemory(origin, sizes, calibration, wire::FrameCoder::most_packets(sizes)) {}
};

}  // namespace stof::test
