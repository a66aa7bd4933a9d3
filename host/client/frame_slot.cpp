#include "host/client/frame_slot.h"

#include <algorithm>
#include <span>

#include "firmware/wire/bytes.h"

namespace stof::client {
namespace {

constexpr std::size_t kWordBits = 64;

std::size_t pixels_of(const wire::Header& header) noexcept {
  return std::size_t{header.image_width} * header.image_height;
}

// Stores the pixels of one tile unless one of them is there already.
template <typename T>
bool store(std::span<const std::byte> payload, std::size_t first, std::uint8_t bit,
           std::vector<T>& pixels, std::vector<std::uint8_t>& received) {
  const std::size_t count = payload.size() / sizeof(T);
  const std::span<std::uint8_t> marks = std::span(received).subspan(first, count);
  std::uint8_t seen = 0;
  for (const std::uint8_t mark : marks) {
    seen |= mark;
  }
  if ((seen & bit) != 0) {
    return false;
  }
  for (std::uint8_t& mark : marks) {
    mark |= bit;
  }
  wire::get_pixels(payload, std::span(pixels).subspan(first, count));
  return true;
}

}  // namespace

bool test_bit(const std::vector<std::uint64_t>& bits, std::size_t index) noexcept {
  return index / kWordBits < bits.size() &&
         ((bits[index / kWordBits] >> (index % kWordBits)) & 1) != 0;
}

void FrameSlot::begin(const wire::Header& header, Time now) {
  const std::size_t pixels = pixels_of(header);
  state = State::kOpen;
  header_ = header;
  first_packet_ = now;
  last_packet_ = now;
  received_packets_ = 0;
  packets_.assign((header.count + kWordBits - 1) / kWordBits, 0);
  depth_.assign(pixels, dsp::kNoDepth);
  width_.assign(pixels, 0);
  source_.assign(pixels, dsp::Source::kNone);
  received_.assign(pixels, 0);
  received_depth_ = 0;
  received_width_ = 0;
  received_source_ = 0;
  info_.reset();
  calibration_.reset();
}

bool FrameSlot::agrees(const wire::Header& header) const noexcept {
  return header.frame.freshness == header_.frame.freshness &&
         header.frame.exposure_middle_ns == header_.frame.exposure_middle_ns &&
         header.count == header_.count && header.image_width == header_.image_width &&
         header.image_height == header_.image_height;
}

Placed FrameSlot::add(const wire::PacketView& packet, Time now) {
  const wire::Header& header = packet.header;
  if (!agrees(header)) {
    return Placed::kContradicting;
  }
  if (test_bit(packets_, header.index)) {
    return Placed::kDuplicate;
  }
  Placed placed = Placed::kIgnored;
  if (header.type == wire::PacketType::kTile) {
    placed = add_tile(packet);
  } else if (header.type == wire::PacketType::kFrameInfo) {
    const Result<wire::FrameInfo> info = wire::decode_frame_info(packet.payload);
    placed = info && !info_ ? Placed::kStored : Placed::kContradicting;
    if (placed == Placed::kStored) {
      info_ = *info;
    }
  }
  if (placed != Placed::kContradicting) {
    packets_[header.index / kWordBits] |= std::uint64_t{1} << (header.index % kWordBits);
    ++received_packets_;
    last_packet_ = now;
  }
  return placed;
}

Placed FrameSlot::add_tile(const wire::PacketView& packet) {
  const wire::Header& header = packet.header;
  const std::size_t first =
      std::size_t{header.first_row} * header.image_width + header.first_column;
  if (wire::pixel_bytes(header.stream, header.codec) == 0) {
    return Placed::kIgnored;
  }
  bool stored = false;
  switch (header.stream) {
    case wire::Stream::kDepth:
      stored = store(packet.payload, first, kHasDepth, depth_, received_);
      received_depth_ += stored ? header.pixel_count : 0;
      break;
    case wire::Stream::kWidth:
      stored = store(packet.payload, first, kHasWidth, width_, received_);
      received_width_ += stored ? header.pixel_count : 0;
      break;
    case wire::Stream::kSource:
      stored = store(packet.payload, first, kHasSource, source_, received_);
      received_source_ += stored ? header.pixel_count : 0;
      break;
    default:
      return Placed::kIgnored;
  }
  return stored ? Placed::kStored : Placed::kContradicting;
}

Frame FrameSlot::view() const {
  const int columns = header_.image_width;
  const int rows = header_.image_height;
  const auto pixels = static_cast<std::uint32_t>(pixels_of(header_));
  return {.origin = header_.origin,
          .stamp = header_.frame,
          .depth = {depth_.data(), columns, rows},
          .width = {width_.data(), columns, rows},
          .source = {source_.data(), columns, rows},
          .received = {received_.data(), columns, rows},
          .missing_depth = pixels - received_depth_,
          .missing_width = pixels - received_width_,
          .missing_source = pixels - received_source_,
          .packets = header_.count,
          .missing_packets = missing_packets(),
          .info = info_,
          .calibration = calibration_,
          .first_packet = first_packet_,
          .last_packet = last_packet_};
}

}  // namespace stof::client
