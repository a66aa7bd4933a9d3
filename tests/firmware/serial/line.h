#pragma once

#include <cstring>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "firmware/serial/line/byte_ring.h"
#include "firmware/serial/serial_sender.h"
#include "firmware/wire/codec/rvl_decode.h"
#include "firmware/wire/messages/frame_info.h"
#include "firmware/wire/packet.h"
#include "hal/framing/cobs.h"
#include "tests/support/guarded_part.h"

// The far end of a serial line, and a sender with its memory.
namespace stof::firmware::test {

using Bytes = std::vector<std::byte>;

struct LinePacket {
  wire::Header header;
  Bytes payload;
};

struct LineFrame {
  std::uint16_t parts = 0;
  std::uint16_t count = 0;
  int columns = 0;
  int rows = 0;
  std::vector<std::uint16_t> depth;
  std::vector<std::uint16_t> width;

  bool whole() const { return parts == count && count > 0; }
};

// Bytes of a line to packets and pictures.
class LineReceiver {
 public:
  void feed(std::span<const std::byte> bytes) {
    while (const auto frame = reader_.take(bytes)) {
      const auto packet = wire::parse_packet(*frame);
      if (!packet) {
        ++damaged;
        continue;
      }
      packets.push_back({packet->header, {packet->payload.begin(), packet->payload.end()}});
      if (wire::part_of_frame(packet->header.type)) {
        take(*packet);
      }
    }
  }
  void feed(std::string_view text) { feed(std::as_bytes(std::span(text))); }

  std::size_t count(wire::PacketType type) const {
    std::size_t found = 0;
    for (const LinePacket& packet : packets) {
      found += packet.header.type == type ? 1U : 0U;
    }
    return found;
  }
  std::size_t whole_frames() const {
    std::size_t found = 0;
    for (const auto& [number, frame] : frames) {
      found += frame.whole() ? 1U : 0U;
    }
    return found;
  }
  // The last one of its type.
  const LinePacket* last(wire::PacketType type) const {
    const LinePacket* found = nullptr;
    for (const LinePacket& packet : packets) {
      found = packet.header.type == type ? &packet : found;
    }
    return found;
  }

  std::vector<LinePacket> packets;
  std::map<std::uint32_t, LineFrame> frames;
  std::size_t damaged = 0;

 private:
  void take(const wire::PacketView& packet) {
    const wire::Header& header = packet.header;
    LineFrame& frame = frames[header.frame.number];
    ++frame.parts;
    frame.count = header.count;
    if (header.type != wire::PacketType::kTile) {
      return;
    }
    frame.columns = header.image_width;
    frame.rows = header.image_height;
    std::vector<std::uint16_t>& image =
        header.stream == wire::Stream::kDepth ? frame.depth : frame.width;
    image.resize(std::size_t{header.image_width} * header.image_height);
    const std::span<std::uint16_t> pixels = std::span(image).subspan(
        std::size_t{header.first_row} * header.image_width + header.first_column,
        header.pixel_count);
    if (header.codec == wire::Codec::kRaw16) {
      std::memcpy(pixels.data(), packet.payload.data(), pixels.size_bytes());
    } else if (wire::rvl_decode(packet.payload, pixels) != Status::kOk) {
      ++damaged;
    }
  }

  hal::CobsReader reader_;
};

inline wire::CalibrationPacket calibration_of(int width, int height) {
  return {.image_width = static_cast<std::uint16_t>(width),
          .image_height = static_cast<std::uint16_t>(height),
          .fx = 500 << 16,
          .fy = 500 << 16,
          .cx = (width << 15) - (1 << 15),
          .cy = (height << 15) - (1 << 15),
          .max_range = 40'000,
          .baseline_nm = 100'000'000};
}

class SenderBench {
 public:
  explicit SenderBench(int columns = 640, int rows = 480,
                       std::size_t ring_bytes = SerialSender::kRingBytes)
      : setup{.origin = {.device_id = 5, .session_id = 6},
              .calibration = calibration_of(columns, rows)},
        ring_memory(ring_bytes),
        ring(ring_memory),
        in_memory([&](dsp::Arena& arena) { return SerialSender(setup, ring, arena); }),
        depth(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows)),
        width(depth.size()) {}

  dsp::DepthMap map() {
    const int columns = setup.calibration.image_width;
    const int rows = setup.calibration.image_height;
    return {.depth = {depth.data(), columns, rows},
            .width = {width.data(), columns, rows},
            .source = {}};
  }
  void frame(hal::Time now) {
    ++stamp.number;
    stamp.exposure_middle_ns = now.time_since_epoch().count();
    sender.frame(stamp, info, map(), now);
  }
  // The bytes of all records, and how many there were.
  std::size_t drain() {
    std::size_t bytes = 0;
    Bytes record(wire::kMaxDatagram);
    while (const std::size_t size = ring.take(record)) {
      bytes += size;
      records.emplace_back(record.begin(), record.begin() + static_cast<std::ptrdiff_t>(size));
    }
    return bytes;
  }

  SerialSetup setup;
  Bytes ring_memory;
  ByteRing ring;
  stof::test::GuardedPart<SerialSender> in_memory;
  SerialSender& sender = *in_memory;
  wire::FrameStamp stamp{.number = 100, .freshness = 1};
  wire::FrameInfo info;
  std::vector<dsp::QuarterMm> depth;
  std::vector<dsp::QuarterMm> width;
  std::vector<Bytes> records;
};

}  // namespace stof::firmware::test
