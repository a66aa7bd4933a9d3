#include "host/client/frame/frame_slot.h"

namespace stof::client {
namespace {

constexpr std::size_t kWordBits = 64;

// What parity made lacks what a newer sender may write into its headers.
bool is_of(std::uint32_t crc, const wire::PacketView& packet) noexcept {
  return crc == packet.crc || crc == wire::plain_crc(packet);
}

}  // namespace

bool PacketMark::contradicts(const wire::PacketView& packet) const noexcept {
  const wire::Header& header = packet.header;
  return count != 0 && header.frame.number == number &&
         (header.count != count || (header.index == index && !is_of(crc, packet)));
}

void PacketSet::begin(std::size_t count) {
  words_.assign((count + kWordBits - 1) / kWordBits, 0);
  crcs_.assign(count, 0);
}

bool PacketSet::has(std::size_t index) const noexcept {
  return index / kWordBits < words_.size() &&
         ((words_[index / kWordBits] >> (index % kWordBits)) & 1) != 0;
}

void PacketSet::insert(std::size_t index, const wire::PacketView& packet) noexcept {
  words_[index / kWordBits] |= std::uint64_t{1} << (index % kWordBits);
  crcs_[index] = packet.crc != 0 ? packet.crc : wire::plain_crc(packet);
}

bool PacketSet::differs(std::size_t index, const wire::PacketView& packet) const noexcept {
  return has(index) && !is_of(crcs_[index], packet);
}

PacketMark PacketSet::mark(std::uint32_t number) const noexcept {
  const std::size_t count = crcs_.size();
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t index = (number + k) % count;
    if (has(index)) {
      return {.number = number,
              .count = static_cast<std::uint16_t>(count),
              .index = static_cast<std::uint16_t>(index),
              .crc = crcs_[index]};
    }
  }
  return {};
}

void FrameSlot::begin(const wire::Header& header, bool parity, Time now) {
  state = State::kOpen;
  header_ = header;
  first_packet_ = now;
  last_packet_ = now;
  received_packets_ = 0;
  recovered_ = 0;
  packets_.begin(header.count);
  parity_packets_.begin(wire::parity_groups(header.count));
  parity_arrived_ = 0;
  groups_.clear();
  if (parity) {
    begin_parity();
  }
  pixels_.begin();
  info_.reset();
  calibration_.reset();
}

void FrameSlot::begin_parity() {
  groups_.assign(wire::parity_groups(header_.count), wire::ParityGroup{});
}

bool FrameSlot::agrees(const wire::FrameStamp& stamp) const noexcept {
  return stamp.freshness == header_.frame.freshness &&
         stamp.exposure_middle_ns == header_.frame.exposure_middle_ns;
}

Placed FrameSlot::add(const wire::PacketView& part, Time now) {
  const wire::Header& header = part.header;
  if (!agrees(header.frame) || header.count != header_.count) {
    return Placed::kContradicting;
  }
  if (packets_.has(header.index)) {
    return packets_.differs(header.index, part) ? Placed::kContradicting : Placed::kDuplicate;
  }
  Placed placed = Placed::kIgnored;
  if (header.type == wire::PacketType::kTile) {
    placed = pixels_.add(part);
  } else if (header.type == wire::PacketType::kFrameInfo) {
    placed = add_info(part);
  }
  if (placed == Placed::kContradicting) {
    return placed;
  }
  packets_.insert(header.index, part);
  ++received_packets_;
  last_packet_ = now;
  if (parity() && !groups_[group_of(header.index)].one_is_missing()) {
    // A part too long for parity is not of a sender that uses it: its group recovers nothing.
    static_cast<void>(groups_[group_of(header.index)].add(header, part.payload));
  }
  return placed;
}

Placed FrameSlot::add_info(const wire::PacketView& part) {
  const Result<wire::FrameInfo> info = wire::read_frame_info(part.payload);
  if (!info || info_ || !pixels_.expect(part.header, *info)) {
    return Placed::kContradicting;
  }
  info_ = *info;
  if (info->parity_groups != 0 && !parity()) {
    begin_parity();
  }
  return Placed::kStored;
}

Placed FrameSlot::add_parity(const wire::PacketView& packet, Time now) {
  const Result<wire::ParityFields> fields = wire::decode_parity_fields(packet.payload);
  const std::size_t group = packet.header.index;
  if (!fields || fields->count != header_.count || !agrees(packet.header.frame) ||
      !has_parity(group, true)) {
    return Placed::kContradicting;
  }
  if (parity_packets_.has(group)) {
    return parity_packets_.differs(group, packet) ? Placed::kContradicting : Placed::kDuplicate;
  }
  if (parity()) {
    if (group >= groups_.size() || groups_[group].add_parity(packet) != Status::kOk) {
      return Placed::kContradicting;
    }
  } else if (group >= wire::parity_groups(header_.count)) {
    return Placed::kContradicting;
  }
  parity_packets_.insert(group, packet);
  ++parity_arrived_;
  last_packet_ = now;
  return Placed::kStored;
}

bool FrameSlot::has_parity(std::size_t group, bool told) const noexcept {
  constexpr std::size_t kOrMore = 255;
  return info_ ? group < info_->parity_groups || info_->parity_groups == kOrMore : told;
}

bool FrameSlot::drop_false_parity() {
  if (!told_no_parity() || parity_arrived_ == 0) {
    return false;
  }
  groups_.clear();
  parity_packets_.begin(wire::parity_groups(header_.count));
  parity_arrived_ = 0;
  return true;
}

std::optional<wire::PacketView> FrameSlot::recover(std::size_t group) const {
  if (!groups_[group].one_is_missing()) {
    return std::nullopt;
  }
  const Result<wire::PacketView> packet = groups_[group].recover();
  return packet ? std::optional(*packet) : std::nullopt;
}

ImageSize FrameSlot::depth_size() const {
  const Frame frame = view();
  return {.width = frame.depth.width(), .height = frame.depth.height()};
}

// A frame names the calibration that it was made with; where that did not come yet it has none.
void FrameSlot::choose_calibration(const LensBook& told) {
  calibration_ = told.of(made_with(), depth_size());
}

Frame FrameSlot::view() const {
  Frame frame{.origin = header_.origin,
              .stamp = header_.frame,
              .packets = header_.count,
              .missing_packets = missing_packets(),
              .recovered_packets = recovered_,
              .info = info_,
              .calibration = calibration_,
              .first_packet = first_packet_,
              .last_packet = last_packet_};
  pixels_.view(frame);
  return frame;
}

}  // namespace stof::client
