#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "firmware/wire/packet.h"
#include "host/client/frame.h"

namespace stof::client {

// How the numbers of frames compare when they wrap: negative, 0 or positive as a is before, at or
// after b.
constexpr std::int32_t number_distance(std::uint32_t a, std::uint32_t b) noexcept {
  return static_cast<std::int32_t>(a - b);
}

// What became of one packet in its frame.
enum class Placed : std::uint8_t {
  kStored,
  kIgnored,  // of a newer kind; counted for completeness, nothing to keep
  kDuplicate,
  kContradicting,  // with the frame's other packets, or its pixels are there already
};

// One frame being put together. Keeps its memory from frame to frame.
class FrameSlot {
 public:
  enum class State : std::uint8_t { kFree, kOpen, kFinished, kOut };

  State state = State::kFree;
  std::uint64_t order = 0;  // of finishing

  // Clears every pixel: whatever was here before is gone.
  void begin(const wire::Header& header, Time now);

  // packet: of this frame's number and session; a tile is consistent_tile() or of unknown kind.
  Placed add(const wire::PacketView& packet, Time now);

  bool complete() const noexcept { return received_packets_ == header_.count; }
  std::uint32_t missing_packets() const noexcept { return header_.count - received_packets_; }
  std::uint32_t number() const noexcept { return header_.frame.number; }
  std::uint32_t freshness() const noexcept { return header_.frame.freshness; }
  Time last_packet() const noexcept { return last_packet_; }
  const std::vector<std::uint64_t>& packets() const noexcept { return packets_; }
  void keep_calibration(const std::optional<wire::CalibrationPacket>& calibration) {
    calibration_ = calibration;
  }

  Frame view() const;

 private:
  bool agrees(const wire::Header& header) const noexcept;
  Placed add_tile(const wire::PacketView& packet);

  wire::Header header_;  // of the packet that came first
  Time first_packet_;
  Time last_packet_;
  std::uint32_t received_packets_ = 0;
  std::vector<std::uint64_t> packets_;  // one bit each
  std::vector<dsp::QuarterMm> depth_;
  std::vector<dsp::QuarterMm> width_;
  std::vector<dsp::Source> source_;
  std::vector<std::uint8_t> received_;
  std::uint32_t received_depth_ = 0;
  std::uint32_t received_width_ = 0;
  std::uint32_t received_source_ = 0;
  std::optional<wire::FrameInfo> info_;
  std::optional<wire::CalibrationPacket> calibration_;
};

// Whether bit `index` is set; false beyond the end.
bool test_bit(const std::vector<std::uint64_t>& bits, std::size_t index) noexcept;

}  // namespace stof::client
