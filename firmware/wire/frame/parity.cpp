#include "firmware/wire/frame/parity.h"

#include <algorithm>

#include "dsp/base/check.h"

namespace stof::wire {
namespace {

void add_fields(const ParityFields& fields, ParityFields& sum) noexcept {
  sum.type ^= fields.type;
  sum.flags ^= fields.flags;
  sum.stream ^= fields.stream;
  sum.codec ^= fields.codec;
  sum.image_width ^= fields.image_width;
  sum.image_height ^= fields.image_height;
  sum.first_row ^= fields.first_row;
  sum.first_column ^= fields.first_column;
  sum.pixel_count ^= fields.pixel_count;
  sum.payload_length ^= fields.payload_length;
}

// The exclusive or of all indices of a group.
std::uint16_t index_sum(std::uint16_t count, std::uint16_t group) noexcept {
  std::uint16_t sum = 0;
  for (int index = group; index < count; index += parity_groups(count)) {
    sum ^= static_cast<std::uint16_t>(index);
  }
  return sum;
}

bool zeros(std::span<const std::byte> bytes) noexcept {
  return std::ranges::all_of(bytes, [](std::byte byte) { return byte == std::byte{}; });
}

}  // namespace

void ParityGroup::add_bytes(std::span<const std::byte> payload) noexcept {
  for (std::size_t i = 0; i < payload.size(); ++i) {
    bytes_[i] ^= payload[i];
  }
  longest_ = std::max(longest_, static_cast<std::uint16_t>(payload.size()));
}

Status ParityGroup::add(const Header& header, std::span<const std::byte> payload) noexcept {
  if (payload.size() > kMaxParityData) {
    return Status::kTooLarge;
  }
  add_fields({.type = static_cast<std::uint8_t>(header.type),
              .flags = header.flags,
              .stream = static_cast<std::uint8_t>(header.stream),
              .codec = static_cast<std::uint8_t>(header.codec),
              .image_width = header.image_width,
              .image_height = header.image_height,
              .first_row = header.first_row,
              .first_column = header.first_column,
              .pixel_count = header.pixel_count,
              .payload_length = static_cast<std::uint16_t>(payload.size())},
             sum_);
  index_sum_ ^= header.index;
  ++members_;
  add_bytes(payload);
  return Status::kOk;
}

Status ParityGroup::add_parity(const PacketView& packet) noexcept {
  const Result<ParityFields> fields = decode_parity_fields(packet.payload);
  if (!fields || packet.header.type != PacketType::kParity || packet.payload.size() > kMaxPayload ||
      fields->count == 0 || packet.header.count != parity_groups(fields->count) ||
      packet.header.index >= packet.header.count) {
    return Status::kCorrupt;
  }
  add_fields(*fields, sum_);
  add_bytes(packet.payload.subspan(kParityFieldsBytes));
  parity_ = packet.header;
  frame_count_ = fields->count;
  return Status::kOk;
}

bool ParityGroup::one_is_missing() const noexcept {
  return frame_count_ > 0 && members_ + 1 == parity_members(frame_count_, parity_.index);
}

Result<PacketView> ParityGroup::recover() const& noexcept {
  if (!one_is_missing()) {
    return fail(Status::kInvalidArgument);
  }
  const std::uint16_t group = parity_.index;
  const Header header{
      .type = static_cast<PacketType>(sum_.type),
      .flags = sum_.flags,
      .origin = parity_.origin,
      .frame = parity_.frame,
      .stream = static_cast<Stream>(sum_.stream),
      .codec = static_cast<Codec>(sum_.codec),
      .index = static_cast<std::uint16_t>(index_sum_ ^ index_sum(frame_count_, group)),
      .count = frame_count_,
      .image_width = sum_.image_width,
      .image_height = sum_.image_height,
      .first_row = sum_.first_row,
      .first_column = sum_.first_column,
      .pixel_count = sum_.pixel_count};
  const std::span<const std::byte> bytes = std::span(bytes_).first(longest_);
  if (!part_of_frame(header.type) || header.index >= frame_count_ ||
      header.index % parity_.count != group || sum_.payload_length > bytes.size() ||
      !zeros(bytes.subspan(sum_.payload_length))) {
    return fail(Status::kCorrupt);
  }
  return PacketView{.header = header, .payload = bytes.first(sum_.payload_length)};
}

std::size_t ParityGroup::write(std::uint16_t frame_count,
                               std::span<std::byte, kMaxPayload> out) const noexcept {
  ParityFields fields = sum_;
  fields.count = frame_count;
  encode_parity_fields(fields, out.first<kParityFieldsBytes>());
  std::ranges::copy(std::span(bytes_).first(longest_), out.begin() + kParityFieldsBytes);
  return kParityFieldsBytes + longest_;
}

}  // namespace stof::wire
