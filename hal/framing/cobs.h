#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "hal/datagram_size.h"

// Consistent overhead byte stuffing (Cheshire and Baker, IEEE/ACM Trans. Networking 7(2), 1999): a
// frame without any zero byte, so that a zero ends it and nothing else.
namespace stof::hal {

// Longest code of a frame, without the zero behind it: one byte more for each begun 254.
constexpr std::size_t cobs_bound(std::size_t bytes) noexcept { return bytes + bytes / 254 + 1; }

// Writes the code of `frame`, without a zero behind it, to the front of `out`, which has room for
// cobs_bound(frame.size()) bytes and does not overlap. Returns its length.
std::size_t cobs_encode(std::span<const std::byte> frame, std::span<std::byte> out) noexcept;

// Bytes of a line into frames, each ended by a zero. After damage or at the line's begin, the next
// zero is where the next frame begins. Bytes between are handed out as they decode, or counted.
class CobsReader {
 public:
  static constexpr std::size_t kMaxFrame = kMaxDatagram;

  struct Counters {
    std::uint64_t frames = 0;    // handed out
    std::uint64_t empty = 0;     // zeros that ended nothing: filling, no error
    std::uint64_t broken = 0;    // ended inside a block
    std::uint64_t too_long = 0;  // above kMaxFrame
  };

  // Takes bytes from the front of `bytes` until a frame ends, at most all of them. Call it again
  // while it returns one. The frame is valid until the next call.
  std::optional<std::span<const std::byte>> take(std::span<const std::byte>& bytes) noexcept;
  // Forgets what has been read of a frame.
  void reset() noexcept;

  const Counters& counters() const noexcept { return counters_; }

 private:
  std::optional<std::span<const std::byte>> end() noexcept;
  void append(std::byte value) noexcept;

  std::array<std::byte, kMaxFrame> frame_{};
  std::size_t size_ = 0;
  unsigned left_ = 0;          // bytes of the block that are still to come
  bool begun_ = false;         // a byte of this frame has been read
  bool zero_pending_ = false;  // the block stands for a zero, unless it is the last one
  bool too_long_ = false;
  Counters counters_;
};

}  // namespace stof::hal
