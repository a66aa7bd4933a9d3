#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "dsp/fusion/depth_map.h"
#include "firmware/wire/packet.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/random.h"

namespace stof::test {

using Datagram = std::vector<std::byte>;

inline constexpr wire::Origin kOrigin{.device_id = 0x0A0B0C0D, .session_id = 0x11223344};

// A depth map with its pixels: random, every value of every format possible. The rows of the views
// have a gap, and the last one ends at an unreadable page.
class RandomMap {
 public:
  RandomMap(int width, int height, std::uint64_t seed)
      : depth_(width, height, width + 3),
        width_(width, height, width + 1),
        source_(width, height, width + 5) {
    Random random(seed);
    for (int y = 0; y < height; ++y) {
      random.fill(depth_.view().row(y));
      random.fill(width_.view().row(y));
      for (dsp::Source& source : source_.view().row(y)) {
        source = static_cast<dsp::Source>(random.between(0, 255));
      }
    }
  }

  dsp::DepthMap view() { return {depth_.view(), width_.view(), source_.view()}; }

 private:
  GuardedImage<dsp::QuarterMm> depth_;
  GuardedImage<dsp::QuarterMm> width_;
  GuardedImage<dsp::Source> source_;
};

// Parses bytes that end at an unreadable page: reading one too far faults.
inline auto parse_guarded(std::span<const std::byte> bytes) {
  GuardedBuffer<std::byte> guarded(bytes.size());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    guarded[i] = bytes[i];
  }
  auto parsed = wire::parse_packet(guarded.span());
  if (parsed) {
    parsed->payload = {};  // points into memory that is about to go
  }
  return parsed;
}

}  // namespace stof::test
