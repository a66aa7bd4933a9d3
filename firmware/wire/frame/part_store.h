#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/check.h"
#include "firmware/wire/frame/parity.h"
#include "firmware/wire/packet.h"

namespace stof::wire {

// A part of a frame whose payload is written; what its header says beside the frame's stamp.
struct Part {
  PacketType type = PacketType::kTile;
  Stream stream = Stream::kNone;
  Codec codec = Codec::kNone;
  std::uint8_t flags = 0;
  std::uint16_t image_width = 0;
  std::uint16_t image_height = 0;
  std::uint16_t first_row = 0;
  std::uint16_t first_column = 0;
  std::uint16_t pixel_count = 0;
  std::uint16_t payload_bytes = 0;
};

// Gets parts begin to end - 1 as soon as they are final, all of a frame in their order.
class PartSink {
 public:
  virtual ~PartSink() = default;
  virtual void take(std::size_t begin, std::size_t end) noexcept = 0;
};

// The parts of a frame before they are sealed, in memory of the caller: at least two buffers, as
// many parts as a frame has. Only the newest parts have a buffer: of those before, unless a sink
// got them, nothing is left but what their headers say.
class PartStore {
 public:
  PartStore() noexcept = default;
  PartStore(std::span<DatagramBuffer> buffers, std::span<Part> parts) noexcept
      : buffers_(buffers), parts_(parts) {}

  std::size_t size() const noexcept { return size_; }
  std::size_t buffers() const noexcept { return buffers_.size(); }
  // Whether every payload since clear() had a buffer of its own.
  bool whole() const noexcept { return used_ <= buffers_.size(); }
  Part& part(std::size_t index) noexcept { return parts_[index]; }
  DatagramBuffer& buffer(std::size_t index) noexcept { return buffers_[index % buffers_.size()]; }
  std::span<std::byte, kMaxPayload> payload(std::size_t index) noexcept {
    used_ = std::max(used_, index + 1);
    return payload_space(buffer(index));
  }

  // The payload of the part that is added next.
  std::span<std::byte, kMaxTilePayload> space() noexcept {
    return payload(size_).first<kMaxTilePayload>();
  }
  // All parts before the last one are final then, where there is a sink.
  void add(const Part& part) noexcept {
    STOF_CHECK(size_ < parts_.size());
    parts_[size_++] = part;
    if (sink_ != nullptr && size_ - taken_ + 1 >= buffers_.size()) {
      hand_over(size_ - 1);
    }
  }
  // Not behind what a sink got.
  void cut_back(std::size_t size) noexcept {
    STOF_CHECK(size >= taken_);
    size_ = std::min(size_, size);
  }

  // Begins a frame; finish() hands over what is left of it.
  void clear(PartSink* sink = nullptr) noexcept {
    sink_ = sink;
    size_ = taken_ = used_ = 0;
  }
  void finish() noexcept { hand_over(size_); }

 private:
  void hand_over(std::size_t end) noexcept {
    sink_->take(taken_, end);
    taken_ = end;
  }

  std::span<DatagramBuffer> buffers_;
  std::span<Part> parts_;
  std::size_t size_ = 0;
  std::size_t used_ = 0;
  PartSink* sink_ = nullptr;
  std::size_t taken_ = 0;
};

}  // namespace stof::wire
