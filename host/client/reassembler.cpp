#include "host/client/reassembler.h"

#include <algorithm>

namespace stof::client {
namespace {

constexpr Duration kSilence = std::chrono::seconds(1);
constexpr Duration kShortestTimeout = std::chrono::milliseconds(100);
constexpr Duration kLongestTimeout = std::chrono::seconds(10);

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
  } else if (header.type == wire::PacketType::kCalibration) {
    push_calibration(*packet);
  } else {
    ++statistics_.unknown;
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
  newest_.reset();
  last_closed_.reset();
  freshness_.reset();
  calibration_.reset();
  closed_count_ = 0;
}

void Reassembler::push_calibration(const wire::PacketView& packet) {
  const Result<wire::CalibrationPacket> decoded = wire::read_calibration_packet(packet.payload);
  if (!decoded) {
    ++statistics_.bad_field;
    return;
  }
  const std::uint32_t number = packet.header.frame.number;
  if (calibration_ && number_distance(number, calibration_frame_) < 0) {
    ++statistics_.late;
    return;
  }
  calibration_ = *decoded;
  calibration_frame_ = number;
  ++statistics_.packets_ok;
}

void Reassembler::push_part(const wire::PacketView& packet, Time now) {
  const wire::Header& header = packet.header;
  if (contradicts_itself(packet)) {
    ++statistics_.bad_field;
    return;
  }
  if (std::size_t{header.image_width} * header.image_height > options_.max_pixels) {
    ++statistics_.oversized;
    return;
  }
  const std::uint32_t number = header.frame.number;
  // Two are in flight: with n seen, n - 1 may still begin.
  const bool over = (last_closed_ && number_distance(number, *last_closed_) <= 0) ||
                    (newest_ && number_distance(number, *newest_) < -1);
  if (over) {
    refuse_closed(header);
    return;
  }
  FrameSlot& slot = open(header, now);
  switch (slot.add(packet, now)) {
    case Placed::kStored:
      ++statistics_.packets_ok;
      break;
    case Placed::kIgnored:
      ++statistics_.unknown;
      break;
    case Placed::kDuplicate:
      ++statistics_.duplicate;
      return;
    case Placed::kContradicting:
      ++statistics_.bad_field;
      return;
  }
  if (slot.complete()) {
    close_older_than(number);
    close(slot);
  }
}

void Reassembler::refuse_closed(const wire::Header& header) {
  const std::size_t known = std::min(closed_count_, kClosed);
  for (std::size_t i = 0; i < known; ++i) {
    if (closed_[i].number == header.frame.number && test_bit(closed_[i].packets, header.index)) {
      ++statistics_.duplicate;
      return;
    }
  }
  ++statistics_.late;
}

// The slot of this packet's frame, begun when it is the frame's first.
FrameSlot& Reassembler::open(const wire::Header& header, Time now) {
  const std::uint32_t number = header.frame.number;
  for (FrameSlot& slot : slots_) {
    if (slot.state == FrameSlot::State::kOpen && slot.number() == number) {
      return slot;
    }
  }
  if (!newest_ || number_distance(number, *newest_) > 0) {
    newest_ = number;
    close_older_than(number - 1);
  }
  FrameSlot* slot = nullptr;
  for (FrameSlot& candidate : slots_) {
    if (candidate.state == FrameSlot::State::kFree) {
      slot = &candidate;
    }
  }
  if (slot == nullptr) {  // nobody took the finished ones
    slot = oldest(FrameSlot::State::kFinished);
    ++statistics_.frames_dropped;
  }
  slot->begin(header, now);
  return *slot;
}

void Reassembler::close_older_than(std::uint32_t number) {
  for (FrameSlot* slot = oldest(FrameSlot::State::kOpen);
       slot != nullptr && number_distance(slot->number(), number) < 0;
       slot = oldest(FrameSlot::State::kOpen)) {
    close(*slot);
  }
}

// Only ever of the oldest open frame: frames finish in the order of their numbers.
void Reassembler::close(FrameSlot& slot) {
  const std::uint32_t number = slot.number();
  if (last_closed_) {
    statistics_.frames_lost += number - *last_closed_ - 1;
  }
  last_closed_ = number;
  statistics_.packets_missing += slot.missing_packets();
  Closed& closed = closed_[closed_count_++ % kClosed];
  closed.number = number;
  closed.packets = slot.packets();

  // The first verified exposure is number 1.
  const bool fresh =
      freshness_ ? number_distance(slot.freshness(), *freshness_) > 0 : slot.freshness() != 0;
  if (!fresh) {
    ++statistics_.frames_stale;
    slot.state = FrameSlot::State::kFree;
    return;
  }
  freshness_ = slot.freshness();
  slot.keep_calibration(calibration_);
  slot.order = ++finished_;
  slot.state = FrameSlot::State::kFinished;
}

std::optional<Frame> Reassembler::take() {
  for (FrameSlot& slot : slots_) {
    if (slot.state == FrameSlot::State::kOut) {
      slot.state = FrameSlot::State::kFree;
    }
  }
  FrameSlot* const slot = oldest(FrameSlot::State::kFinished);
  if (slot == nullptr) {
    return std::nullopt;
  }
  slot->state = FrameSlot::State::kOut;
  ++(slot->complete() ? statistics_.frames_complete : statistics_.frames_incomplete);
  return slot->view();
}

// In the order of finishing, or, of those that are not finished, of their numbers.
FrameSlot* Reassembler::oldest(FrameSlot::State state) {
  FrameSlot* found = nullptr;
  for (FrameSlot& slot : slots_) {
    if (slot.state != state) {
      continue;
    }
    const bool finished = state == FrameSlot::State::kFinished;
    if (found == nullptr || (finished ? slot.order < found->order
                                      : number_distance(slot.number(), found->number()) < 0)) {
      found = &slot;
    }
  }
  return found;
}

Duration Reassembler::frame_timeout() const {
  if (options_.frame_timeout) {
    return *options_.frame_timeout;
  }
  const std::int64_t period_ns = calibration_ ? calibration_->period_ns : 0;
  const std::int64_t bounded = std::clamp<std::int64_t>(period_ns, 0, kLongestTimeout.count());
  return std::clamp(Duration(bounded + bounded / 2), kShortestTimeout, kLongestTimeout);
}

std::optional<Time> Reassembler::next_expiry() const {
  std::optional<Time> first;
  for (const FrameSlot& slot : slots_) {
    if (slot.state == FrameSlot::State::kOpen) {
      const Time expiry = slot.last_packet() + frame_timeout();
      first = first ? std::min(*first, expiry) : expiry;
    }
  }
  return first;
}

void Reassembler::expire(Time now) {
  const Duration timeout = frame_timeout();
  std::optional<std::uint32_t> expired;
  for (const FrameSlot& slot : slots_) {
    if (slot.state == FrameSlot::State::kOpen && now - slot.last_packet() >= timeout &&
        (!expired || number_distance(slot.number(), *expired) > 0)) {
      expired = slot.number();
    }
  }
  if (expired) {
    close_older_than(*expired + 1);
  }
}

}  // namespace stof::client
