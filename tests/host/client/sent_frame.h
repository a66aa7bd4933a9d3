#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "firmware/wire/bytes.h"
#include "firmware/wire/crc32c.h"
#include "firmware/wire/packetizer.h"
#include "host/client/frame.h"
#include "tests/firmware/wire/wire_support.h"

namespace stof::test {

// What a frame is sent as: 13 packets for the default size (frame info, five rows of depth, five of
// width, two tiles of source). Random pixels, others for each seed.
struct FrameSpec {
  std::uint32_t number = 100;
  std::uint32_t freshness = 100;
  std::uint64_t seed = 1;
  wire::Origin origin = kOrigin;
  int width = 300;
  int height = 5;
};

// The frame of this number, fresh, with pixels of its own.
inline FrameSpec frame_spec(std::uint32_t number) {
  return {.number = number, .freshness = number, .seed = number};
}

inline wire::FrameStamp stamp_of(const FrameSpec& spec) {
  return {.number = spec.number,
          .freshness = spec.freshness,
          .exposure_middle_ns = std::int64_t{1'000'000} * spec.number};
}

inline std::vector<Datagram> datagrams(const FrameSpec& spec) {
  RandomMap map(spec.width, spec.height, spec.seed);
  KeepingSink sink;
  wire::Packetizer packetizer(spec.origin, sink);
  static_cast<void>(packetizer.publish(stamp_of(spec), {}, map.view()));
  return sink.sent;
}

inline Datagram calibration_datagram(const FrameSpec& spec, std::int64_t period_ns,
                                     std::int32_t fx = 65536) {
  KeepingSink sink;
  wire::Packetizer packetizer(spec.origin, sink);
  const wire::CalibrationPacket packet{.image_width = static_cast<std::uint16_t>(spec.width),
                                       .image_height = static_cast<std::uint16_t>(spec.height),
                                       .fx = fx,
                                       .fy = 65536,
                                       .period_ns = period_ns};
  static_cast<void>(packetizer.publish(stamp_of(spec), packet));
  return sink.sent.front();
}

// After the bytes of a packet were changed on purpose.
inline void reseal(Datagram& datagram) {
  const std::span<std::byte> bytes(datagram);
  wire::put_u32(bytes.last<4>(), wire::crc32c(bytes.first(bytes.size() - 4)));
}

// The images that `packets` (intact, of one frame, in any order) make: placed one pixel at a time,
// everything else none.
class ExpectedImages {
 public:
  ExpectedImages(const std::vector<Datagram>& packets, int width, int height)
      : depth_(static_cast<std::size_t>(width * height)),
        width_(depth_.size()),
        source_(depth_.size()),
        received_(depth_.size()) {
    for (const Datagram& datagram : packets) {
      const auto packet = wire::parse_packet(datagram);
      if (packet && packet->header.type == wire::PacketType::kTile) {
        place(*packet);
      }
    }
  }

  bool equal(const client::Frame& frame) const {
    return same(frame.depth, depth_) && same(frame.width, width_) && same(frame.source, source_) &&
           same(frame.received, received_);
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
        source_[at] = dsp::Source{wire::get_u8(packet.payload.subspan(i).first<1>())};
        received_[at] |= client::kHasSource;
        continue;
      }
      const bool depth = header.stream == wire::Stream::kDepth;
      (depth ? depth_ : width_)[at] = wire::get_u16(packet.payload.subspan(2 * i).first<2>());
      received_[at] |= depth ? client::kHasDepth : client::kHasWidth;
    }
  }

  template <typename T>
  static bool same(dsp::ImageView<const T> image, const std::vector<T>& pixels) {
    for (int y = 0; y < image.height(); ++y) {
      const std::size_t columns = static_cast<std::size_t>(image.width());
      if (!std::ranges::equal(image.row(y), std::span(pixels).subspan(
                                                static_cast<std::size_t>(y) * columns, columns))) {
        return false;
      }
    }
    return pixels.size() ==
           static_cast<std::size_t>(image.width()) * static_cast<std::size_t>(image.height());
  }

  std::vector<dsp::QuarterMm> depth_;
  std::vector<dsp::QuarterMm> width_;
  std::vector<dsp::Source> source_;
  std::vector<std::uint8_t> received_;
};

}  // namespace stof::test
