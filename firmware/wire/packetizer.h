#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/image.h"
#include "dsp/base/status.h"
#include "dsp/fusion/fuser.h"
#include "firmware/wire/calibration_packet.h"
#include "firmware/wire/frame_info.h"
#include "firmware/wire/packet.h"

namespace stof::wire {

// Where datagrams go; what hal::Link promises.
class PacketSink {
 public:
  virtual ~PacketSink() = default;
  // Takes one datagram whole or not at all and copies it. May wait to pace a frame, never for the
  // network. kWouldBlock: dropped.
  // kDeviceError: dropped, nobody can be reached now. kDeviceLost: reopen.
  virtual Status send(std::span<const std::byte> datagram) noexcept = 0;
};

// What became of a frame's datagrams.
struct Sent {
  Status status = Status::kOk;  // the first that was not kOk
  std::uint32_t packets = 0;    // of the frame; 0 if it was refused
  std::uint32_t dropped = 0;    // of these, not taken by the sink
};

// Pixels of one tile: as many whole rows as fit a datagram, so that a lost packet costs its rows
// only; where not even one row fits, as many pixels as do. width >= 1.
constexpr std::size_t tile_pixels(std::size_t width, std::size_t bytes_per_pixel) noexcept {
  const std::size_t capacity = kMaxPayload / bytes_per_pixel;
  return width <= capacity ? capacity / width * width : capacity;
}

// Tiles of one stream. An empty image has none.
constexpr std::size_t tile_count(std::size_t width, std::size_t height,
                                 std::size_t bytes_per_pixel) noexcept {
  if (width == 0 || height == 0) {
    return 0;
  }
  const std::size_t pixels = tile_pixels(width, bytes_per_pixel);
  return (width * height + pixels - 1) / pixels;
}

// Cuts frames into datagrams, one after the other in one buffer. No heap.
class Packetizer {
 public:
  // The sink outlives the packetizer.
  Packetizer(const Origin& origin, PacketSink& sink) noexcept : origin_(origin), sink_(sink) {}

  // Sends frame info, depth, width and source in this order. A datagram that the sink does not take
  // is counted and the next one is tried; only kDeviceLost ends the frame early (the rest counts as
  // dropped). kInvalidArgument: the images differ in size; kTooLarge: more than 65,535 pixels in a
  // row or column, or packets in all. Then nothing is sent.
  Sent publish(const FrameStamp& frame, const FrameInfo& info, const dsp::DepthMap& map) noexcept;

  // One datagram outside the frame's counting. Statuses of the sink.
  Status publish(const FrameStamp& frame, const CalibrationPacket& calibration) noexcept;

 private:
  template <typename T>
  void send_tiles(Header& header, dsp::ImageView<const T> image, Sent& sent) noexcept;
  void send(const Header& header, std::size_t payload_bytes, Sent& sent) noexcept;

  Origin origin_;
  PacketSink& sink_;
  DatagramBuffer buffer_{};
};

}  // namespace stof::wire
