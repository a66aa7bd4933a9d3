#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "firmware/wire/bytes.h"
#include "firmware/wire/crc32c.h"
#include "host/client/frame/frame.h"
#include "tests/firmware/wire/frame/coder_in_memory.h"
#include "tests/firmware/wire/wire_support.h"

namespace stof::test {

// Depth, width and source, not compressed.
inline wire::StreamChoice raw_map() {
  wire::StreamChoice choice;
  for (const wire::Stream stream :
       {wire::Stream::kDepth, wire::Stream::kWidth, wire::Stream::kSource}) {
    choice.of(stream) = wire::Coding::kRaw;
  }
  return choice;
}

// What a frame is sent as: 13 packets for the default size (frame info, five rows of depth, five of
// width, two tiles of source). Random pixels, others for each seed.
struct FrameSpec {
  std::uint32_t number = 100;
  std::uint32_t freshness = 100;
  std::uint64_t seed = 1;
  wire::Origin origin = kOrigin;
  int width = 300;
  int height = 5;
  bool parity = false;
  std::uint32_t steady_frames = 0;
  std::uint32_t calibration = 0;  // its fingerprint
  std::uint32_t settings = 0;     // their revision
  std::uint32_t max_range_um = 0;
  std::int64_t period_ns = 0;
};

// The frame of this number, fresh, with pixels of its own.
inline FrameSpec frame_spec(std::uint32_t number) {
  return {.number = number, .freshness = number, .seed = number};
}

inline wire::FrameStamp stamp_of(const FrameSpec& spec) {
  return {.number = spec.number,
          .freshness = spec.freshness,
          .exposure_middle_ns = std::int64_t{1'000'000} * spec.number,
          .clock = wire::ClockState::kEmulated};
}

// The appliance's own coder with memory of its own.
class Coder {
 public:
  Coder(const wire::Origin& origin, const wire::FrameSizes& sizes)
      : coder_(origin, sizes, {.fx = 65536, .fy = 65536}) {}

  std::vector<Datagram> code(const wire::FrameStamp& stamp, const wire::FrameImages& images,
                             const wire::StreamChoice& choice, const wire::FrameInfo& info = {}) {
    std::vector<Datagram> packets;
    const auto coded = coder_->code(stamp, info, images, choice);
    if (coded) {
      for (const std::span<const std::byte> packet : *coded) {
        packets.emplace_back(packet.begin(), packet.end());
      }
    }
    return packets;
  }

 private:
  CoderInMemory coder_;
};

inline std::vector<Datagram> datagrams(const FrameSpec& spec) {
  RandomMap map(spec.width, spec.height, spec.seed);
  Coder coder(spec.origin, {.width = spec.width, .height = spec.height});
  wire::StreamChoice choice = raw_map();
  choice.parity = spec.parity;
  return coder.code(stamp_of(spec), {.map = map.view()}, choice,
                    {.settings_revision = spec.settings,
                     .calibration_fingerprint = spec.calibration,
                     .max_range_um = spec.max_range_um,
                     .period_ns = spec.period_ns});
}

inline constexpr std::uint32_t kDepthUnitUm = wire::CalibrationPacket{}.depth_unit_um;

// A packet outside the frames.
inline Datagram report_datagram(const FrameSpec& spec, wire::PacketType type,
                                std::span<const std::byte> payload) {
  wire::DatagramBuffer buffer;
  std::ranges::copy(payload, wire::payload_space(buffer).begin());
  const std::span<const std::byte> sealed = wire::seal_packet(
      {.type = type, .origin = spec.origin, .frame = stamp_of(spec)}, payload.size(), buffer);
  return {sealed.begin(), sealed.end()};
}

inline Datagram calibration_datagram(const FrameSpec& spec, std::int64_t period_ns,
                                     std::int32_t fx = 65536) {
  std::array<std::byte, wire::kCalibrationPacketBytes> payload{};
  wire::encode_calibration_packet({.image_width = static_cast<std::uint16_t>(spec.width),
                                   .image_height = static_cast<std::uint16_t>(spec.height),
                                   .fx = fx,
                                   .fy = 65536,
                                   .max_range = spec.max_range_um / kDepthUnitUm,
                                   .period_ns = period_ns,
                                   .fingerprint = spec.calibration},
                                  payload);
  return report_datagram(spec, wire::PacketType::kCalibration, payload);
}

// After the bytes of a packet were changed on purpose.
inline void reseal(Datagram& datagram) {
  const std::span<std::byte> bytes(datagram);
  wire::put_u32(bytes.last<4>(), wire::crc32c(bytes.first(bytes.size() - 4)));
}

template <typename T>
bool same_pixels(dsp::ImageView<const T> image, const std::vector<T>& pixels) {
  const auto columns = static_cast<std::size_t>(image.width());
  for (int y = 0; y < image.height(); ++y) {
    const std::size_t begin = static_cast<std::size_t>(y) * columns;
    if (begin + columns > pixels.size() ||
        !std::ranges::equal(image.row(y), std::span(pixels).subspan(begin, columns))) {
      return false;
    }
  }
  return pixels.size() == columns * static_cast<std::size_t>(image.height());
}

// The images that `packets` (intact, of one frame, raw, in any order) make: placed one pixel at a
// time, everything else none.
class ExpectedImages {
 public:
  ExpectedImages(const std::vector<Datagram>& packets, int width, int height)
      : depth_(static_cast<std::size_t>(width * height)),
        width_(depth_.size()),
        source_(depth_.size()),
        cause_(depth_.size()),
        received_(depth_.size()) {
    for (const Datagram& datagram : packets) {
      const auto packet = wire::parse_packet(datagram);
      if (packet && packet->header.type == wire::PacketType::kTile) {
        place(*packet);
      }
    }
  }

  // An image of which nothing arrived, and that frame info did not tell of, is empty.
  bool equal(const client::Frame& frame) const {
    return same(frame.depth, depth_, client::kHasDepth) &&
           same(frame.interval_width, width_, client::kHasWidth) &&
           same(frame.source, source_, client::kHasSource) &&
           same(frame.cause, cause_, client::kHasSource) && same_pixels(frame.received, received_);
  }
  std::uint32_t missing(std::uint8_t bit) const {
    return static_cast<std::uint32_t>(
        std::ranges::count_if(received_, [bit](std::uint8_t mark) { return (mark & bit) == 0; }));
  }

 private:
  void place(const wire::PacketView& packet) {
    const wire::Header& header = packet.header;
    for (std::size_t i = 0; i < header.pixel_count; ++i) {
      const std::size_t at =
          std::size_t{header.first_row} * header.image_width + header.first_column + i;
      if (header.stream == wire::Stream::kSource) {
        const std::uint8_t both = wire::get_u8(packet.payload.subspan(i).first<1>());
        source_[at] = static_cast<dsp::Source>(both % 16);
        cause_[at] = static_cast<dsp::Cause>(both / 16);
        received_[at] |= client::kHasSource;
        continue;
      }
      const bool depth = header.stream == wire::Stream::kDepth;
      (depth ? depth_ : width_)[at] = wire::get_u16(packet.payload.subspan(2 * i).first<2>());
      received_[at] |= depth ? client::kHasDepth : client::kHasWidth;
    }
  }

  template <typename T>
  bool same(dsp::ImageView<const T> image, const std::vector<T>& pixels, std::uint8_t bit) const {
    return image.empty() ? missing(bit) == pixels.size() : same_pixels(image, pixels);
  }

  std::vector<dsp::QuarterMm> depth_;
  std::vector<dsp::QuarterMm> width_;
  std::vector<dsp::Source> source_;
  std::vector<dsp::Cause> cause_;
  std::vector<std::uint8_t> received_;
};

}  // namespace stof::test
