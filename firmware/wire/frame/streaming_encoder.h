#pragma once

#include <algorithm>
#include <cstddef>

#include "firmware/wire/frame/frame_sealer.h"
#include "firmware/wire/frame/part_store.h"

namespace stof::wire {

// Sends a frame that is larger than the memory for it. The first pass only counts the packets. The
// second encodes again while sending.
class StreamingEncoder final : public PartSink {
 public:
  StreamingEncoder(const FrameSealer& sealer, DatagramSink& sink) noexcept
      : sealer_(sealer), sink_(sink) {
    sealer_.begin_parity();
  }

  void take(std::size_t begin, std::size_t end) noexcept override {
    sink_.take(sealer_.seal_parts(begin, end), sealer_.all());
  }

  // After all parts.
  void send_parity() noexcept {
    const std::size_t most = sealer_.most_at_once();
    for (std::size_t begin = 0; begin < sealer_.groups(); begin += most) {
      const std::size_t end = std::min(begin + most, sealer_.groups());
      sink_.take(sealer_.seal_parity(begin, end), sealer_.all());
    }
  }

 private:
  FrameSealer sealer_;
  DatagramSink& sink_;
};

}  // namespace stof::wire
