#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace stof::viewer {

// What a WebSocket's client sends, frame by frame (RFC 6455, 5.2), as far as it takes to see that
// each one is masked: a client must, and a server must not take what is not (5.1).
class ClientFrames {
 public:
  // Any part of the stream. Appends what is sound of it to `to`; a head is kept until it has come
  // as a whole. False: a frame is not masked; nothing of it is appended, and nothing that follows.
  bool take(std::span<const std::uint8_t> part, std::vector<std::uint8_t>& to);

 private:
  static constexpr std::size_t kMostHead = 14;

  std::size_t head_size() const noexcept;  // as far as is known
  std::uint64_t payload_size() const noexcept;

  std::array<std::uint8_t, kMostHead> head_{};
  std::size_t come_ = 0;       // of the head
  std::uint64_t payload_ = 0;  // that is to come
  bool refused_ = false;
};

}  // namespace stof::viewer
