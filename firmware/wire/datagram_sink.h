#pragma once

#include <cstddef>
#include <span>

namespace stof::wire {

using Datagrams = std::span<const std::span<const std::byte>>;

// Gets a frame's datagrams in the order of sending: all at once or some at a time.
class DatagramSink {
 public:
  virtual ~DatagramSink() = default;
  // Valid until this returns. all: datagrams of the frame, at every call the same.
  virtual void take(Datagrams datagrams, std::size_t all) noexcept = 0;
};

}  // namespace stof::wire
