#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/wire/packet.h"
#include "host/client/frame/frame_slot.h"

namespace stof::client {

// What arrived of the newest frames that were closed: what comes of them after all is told apart.
class ClosedFrames {
 public:
  enum class Verdict : std::uint8_t {
    kForgotten,      // its frame was closed longer ago
    kLate,           // it was missing
    kRepeated,       // bit for bit
    kContradicting,  // its frame was made of another one, or says that it has none of the kind
    kInOrder,        // parity of a whole frame, which comes behind it
  };

  void forget() noexcept { count_ = 0; }
  void add(const FrameSlot& slot);

  Verdict judge_part(const wire::PacketView& packet) const noexcept;
  // Remembers it.
  Verdict judge_parity(const wire::PacketView& packet);

 private:
  static constexpr std::size_t kFrames = 2;

  struct Closed {
    std::uint32_t number = 0;
    PacketSet packets;
    PacketSet parity;
    std::size_t parity_groups = 0;  // that its packets would have
    bool no_parity = false;         // as its info says
    bool whole = false;
  };

  // Its place; kFrames: none.
  std::size_t find(std::uint32_t number) const noexcept;

  std::array<Closed, kFrames> frames_;
  std::size_t count_ = 0;
};

}  // namespace stof::client
