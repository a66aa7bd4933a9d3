#include "host/client/reassembler.h"

#include <algorithm>

namespace stof::client {
namespace {

constexpr Duration kSilence = std::chrono::seconds(1);

std::uint64_t& counter(Statistics& statistics, wire::PacketFault fault) {
  switch (fault) {
    case wire::PacketFault::kTruncated:
      return statistics.truncated;
    case wire::PacketFault::kMagic:
      return statistics.bad_magic;
    case wire::PacketFault::kVersion:
      return statistics.bad_version;
    case wire::PacketFault::kLength:
      return statistics.bad_length;
    case wire::PacketFault::kCrc:
      return statistics.bad_crc;
    case wire::PacketFault::kField:
      break;
  }
  return statistics.bad_field;
}

std::size_t pixels(const wire::Header& header) {
  return std::size_t{header.image_width} * header.image_height;
}

// Whether a part of a known kind is what it says. What is unknown cannot be judged.
bool contradicts_itself(const wire::PacketView& packet) {
  const wire::Header& header = packet.header;
  if (header.type == wire::PacketType::kTile) {
    return wire::pixel_bytes(header.stream, header.codec) != 0 && !wire::consistent_tile(packet);
  }
  return header.type == wire::PacketType::kFrameInfo && !wire::decode_frame_info(packet.payload);
}

}  // namespace

void Reassembler::push(std::span<const std::byte> datagram, Time now) {
  const auto packet = wire::parse_packet(datagram);
  if (!packet) {
    ++counter(statistics_, packet.error());
    return;
  }
  const wire::Header& header = packet->header;
  if (!accept_origin(header.origin, now)) {
    ++statistics_.foreign;
    return;
  }
  if (wire::part_of_frame(header.type)) {
    push_part(*packet, now);
  } else if (header.type == wire::PacketType::kParity) {
    push_parity(*packet, now);
  } else {
    push_report(*packet);
  }
}

void Reassembler::push_report(const wire::PacketView& packet) {
  switch (packet.header.type) {
    case wire::PacketType::kCalibration:
      count(reports_.push_calibration(packet));
      break;
    case wire::PacketType::kHealth:
      count(reports_.push_health(packet));
      break;
    case wire::PacketType::kEvent: {
      bool overflow = false;
      count(reports_.push_event(packet, overflow));
      statistics_.events_dropped += overflow ? 1 : 0;
      break;
    }
    default:
      ++statistics_.unknown;
      break;
  }
}

void Reassembler::count(Reported reported) {
  switch (reported) {
    case Reported::kTaken:
      ++statistics_.packets_ok;
      break;
    case Reported::kDuplicate:
      ++statistics_.duplicate;
      break;
    case Reported::kLate:
      ++statistics_.late;
      break;
    case Reported::kContradicting:
      ++statistics_.bad_field;
      break;
  }
}

// A session id that was never heard is a start of the sender. One that has ended comes back only
// when the current one is silent: then the change was not a start but a stray packet.
bool Reassembler::accept_origin(const wire::Origin& origin, Time now) {
  const std::optional<std::uint32_t> wanted =
      origin_ ? std::optional(origin_->device_id) : options_.device_id;
  if (wanted && *wanted != origin.device_id) {
    return false;
  }
  if (!origin_ || origin_->session_id != origin.session_id) {
    const auto end =
        retired_.begin() + static_cast<std::ptrdiff_t>(std::min(retired_count_, retired_.size()));
    const bool ended = std::find(retired_.begin(), end, origin.session_id) != end;
    if (ended && now - last_heard_ < kSilence) {
      return false;
    }
    start_session(origin);
  }
  last_heard_ = now;
  return true;
}

void Reassembler::start_session(const wire::Origin& origin) {
  for (FrameSlot& slot : slots_) {
    if (slot.state == FrameSlot::State::kOpen) {
      slot.state = FrameSlot::State::kFree;
      ++statistics_.frames_dropped;
    }
  }
  if (origin_) {
    retired_[retired_count_++ % kRetired] = origin_->session_id;
  }
  origin_ = origin;
  ++statistics_.sessions;
  statistics_.events_dropped += reports_.restart();
  newest_.reset();
  last_closed_.reset();
  freshness_.reset();
  closed_count_ = 0;
  parity_ = false;
}

// Two frames are in flight: with n seen, n - 1 may still begin.
bool Reassembler::over(std::uint32_t number) const {
  return (last_closed_ && number_distance(number, *last_closed_) <= 0) ||
         (newest_ && number_distance(number, *newest_) < -1);
}

bool Reassembler::count(Placed placed) {
  switch (placed) {
    case Placed::kStored:
      ++statistics_.packets_ok;
      break;
    case Placed::kIgnored:
      ++statistics_.unknown;
      break;
    case Placed::kDuplicate:
      ++statistics_.duplicate;
      return false;
    case Placed::kContradicting:
      ++statistics_.bad_field;
      return false;
  }
  return true;
}

void Reassembler::push_part(const wire::PacketView& packet, Time now) {
  const wire::Header& header = packet.header;
  if (contradicts_itself(packet)) {
    ++statistics_.bad_field;
    return;
  }
  if (pixels(header) > options_.max_pixels) {
    ++statistics_.oversized;
    return;
  }
  if (over(header.frame.number)) {
    refuse_closed(header);
    return;
  }
  FrameSlot& slot = open(header, now);
  if (!count(slot.add(packet, now))) {
    return;
  }
  parity_ = parity_ || slot.parity();
  if (slot.parity()) {
    repair(slot, slot.group_of(header.index), now);
  }
  close_if_complete(slot);
}

void Reassembler::push_parity(const wire::PacketView& packet, Time now) {
  const Result<wire::ParityFields> fields = wire::decode_parity_fields(packet.payload);
  if (!fields || fields->count == 0) {
    ++statistics_.bad_field;
    return;
  }
  parity_ = true;
  if (over(packet.header.frame.number)) {
    count_closed_parity(packet.header);
    return;
  }
  wire::Header part = packet.header;  // as one of the parts that are missing
  part.count = fields->count;
  FrameSlot& slot = open(part, now);
  if (!count(slot.add_parity(packet, now))) {
    return;
  }
  if (slot.parity()) {
    repair(slot, packet.header.index, now);
  }
  close_if_complete(slot);
}

// What parity makes good is judged like what arrives.
void Reassembler::repair(FrameSlot& slot, std::size_t group, Time now) {
  const std::optional<wire::PacketView> packet = slot.recover(group);
  if (!packet || contradicts_itself(*packet) || pixels(packet->header) > options_.max_pixels) {
    return;
  }
  const Placed placed = slot.add(*packet, now);
  if (placed == Placed::kStored || placed == Placed::kIgnored) {
    slot.count_recovered();
    ++statistics_.recovered;
  }
}

void Reassembler::close_if_complete(FrameSlot& slot) {
  if (slot.complete()) {
    close_older_than(slot.number());
    close(slot);
  }
}

Reassembler::Closed* Reassembler::closed(std::uint32_t number) {
  const std::size_t known = std::min(closed_count_, kClosed);
  for (std::size_t i = 0; i < known; ++i) {
    if (closed_[i].number == number) {
      return &closed_[i];
    }
  }
  return nullptr;
}

void Reassembler::refuse_closed(const wire::Header& header) {
  const Closed* const frame = closed(header.frame.number);
  ++(frame != nullptr && frame->packets.has(header.index) ? statistics_.duplicate
                                                          : statistics_.late);
}

// The parity of a whole frame comes after it and is as it should be.
void Reassembler::count_closed_parity(const wire::Header& header) {
  Closed* const frame = closed(header.frame.number);
  if (frame == nullptr || header.index >= frame->parity_groups) {
    ++statistics_.late;
  } else if (frame->parity.has(header.index)) {
    ++statistics_.duplicate;
  } else {
    frame->parity.insert(header.index);
    ++(frame->whole ? statistics_.packets_ok : statistics_.late);
  }
}

}  // namespace stof::client
