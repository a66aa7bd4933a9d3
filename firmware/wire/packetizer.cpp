#include "firmware/wire/packetizer.h"

#include <algorithm>
#include <limits>

#include "firmware/wire/bytes.h"

namespace stof::wire {
namespace {

constexpr std::size_t kMaxU16 = std::numeric_limits<std::uint16_t>::max();

// Copies pixels.size() bytes of a run that begins at raster index `first` and may cross rows.
template <typename T>
void put_run(dsp::ImageView<const T> image, std::size_t first,
             std::span<std::byte> bytes) noexcept {
  const std::size_t width = static_cast<std::size_t>(image.width());
  std::size_t row = first / width;
  std::size_t column = first % width;
  while (!bytes.empty()) {
    const std::size_t pixels = std::min(width - column, bytes.size() / sizeof(T));
    put_pixels<T>(bytes.first(pixels * sizeof(T)),
                  image.row(static_cast<int>(row)).subspan(column, pixels));
    bytes = bytes.subspan(pixels * sizeof(T));
    ++row;
    column = 0;
  }
}

constexpr std::size_t kUnitBytes16 = 2;
constexpr std::size_t kUnitBytes8 = 1;

}  // namespace

void Packetizer::send(const Header& header, std::size_t payload_bytes, Sent& sent) noexcept {
  if (sent.status == Status::kDeviceLost) {
    ++sent.dropped;
    return;
  }
  const Status status = sink_.send(seal_packet(header, payload_bytes, buffer_));
  if (status == Status::kOk) {
    return;
  }
  ++sent.dropped;
  if (sent.status == Status::kOk || status == Status::kDeviceLost) {
    sent.status = status;
  }
}

template <typename T>
void Packetizer::send_tiles(Header& header, dsp::ImageView<const T> image, Sent& sent) noexcept {
  const std::size_t width = static_cast<std::size_t>(image.width());
  const std::size_t total = width * static_cast<std::size_t>(image.height());
  const std::size_t step = tile_pixels(width, sizeof(T));
  for (std::size_t first = 0; first < total; first += step) {
    const std::size_t pixels = std::min(step, total - first);
    header.first_row = static_cast<std::uint16_t>(first / width);
    header.first_column = static_cast<std::uint16_t>(first % width);
    header.pixel_count = static_cast<std::uint16_t>(pixels);
    put_run(image, first, payload_space(buffer_).first(pixels * sizeof(T)));
    send(header, pixels * sizeof(T), sent);
    ++header.index;
  }
}

Sent Packetizer::publish(const FrameStamp& frame, const FrameInfo& info,
                         const dsp::DepthMap& map) noexcept {
  if (!same_size(map.depth, map.width) || !same_size(map.depth, map.source)) {
    return {.status = Status::kInvalidArgument};
  }
  const std::size_t width = static_cast<std::size_t>(map.depth.width());
  const std::size_t height = static_cast<std::size_t>(map.depth.height());
  const std::size_t tiles16 = tile_count(width, height, kUnitBytes16);
  const std::size_t tiles8 = tile_count(width, height, kUnitBytes8);
  const std::size_t packets = 1 + 2 * tiles16 + tiles8;
  if (width > kMaxU16 || height > kMaxU16 || packets > kMaxU16) {
    return {.status = Status::kTooLarge};
  }
  Header header{.type = PacketType::kFrameInfo,
                .origin = origin_,
                .frame = frame,
                .count = static_cast<std::uint16_t>(packets),
                .image_width = static_cast<std::uint16_t>(width),
                .image_height = static_cast<std::uint16_t>(height)};
  Sent sent{.packets = static_cast<std::uint32_t>(packets)};

  FrameInfo counted = info;
  counted.tiles[0] = static_cast<std::uint16_t>(tiles16);
  counted.tiles[1] = static_cast<std::uint16_t>(tiles16);
  counted.tiles[2] = static_cast<std::uint16_t>(tiles8);
  encode_frame_info(counted, payload_space(buffer_).first<kFrameInfoBytes>());
  send(header, kFrameInfoBytes, sent);
  ++header.index;
  if (packets == 1) {
    return sent;
  }

  header.type = PacketType::kTile;
  header.codec = Codec::kRaw16;
  header.stream = Stream::kDepth;
  send_tiles<dsp::QuarterMm>(header, map.depth, sent);
  header.stream = Stream::kWidth;
  send_tiles<dsp::QuarterMm>(header, map.width, sent);
  header.codec = Codec::kRaw8;
  header.stream = Stream::kSource;
  send_tiles<dsp::Source>(header, map.source, sent);
  return sent;
}

Status Packetizer::publish(const FrameStamp& frame, const CalibrationPacket& calibration) noexcept {
  const Header header{.type = PacketType::kCalibration,
                      .origin = origin_,
                      .frame = frame,
                      .image_width = calibration.image_width,
                      .image_height = calibration.image_height};
  encode_calibration_packet(calibration, payload_space(buffer_).first<kCalibrationPacketBytes>());
  return sink_.send(seal_packet(header, kCalibrationPacketBytes, buffer_));
}

}  // namespace stof::wire
