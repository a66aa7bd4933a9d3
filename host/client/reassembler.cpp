#include "host/client/reassembler.h"

#include <algorithm>

#include "host/client/frame/packet_checks.h"

namespace stof::client {
namespace {

constexpr Duration kShortestTimeout = std::chrono::milliseconds(100);
constexpr Duration kLongestTimeout = std::chrono::seconds(10);
constexpr Duration kUnknownPeriod = std::chrono::milliseconds(100);
constexpr Duration kAgeBeyondPeriod = std::chrono::milliseconds(100);

using Counter = std::uint64_t Statistics::*;

// By wire::PacketFault.
constexpr std::array<Counter, 6> kFaults{&Statistics::truncated,   &Statistics::bad_magic,
                                         &Statistics::bad_version, &Statistics::bad_length,
                                         &Statistics::bad_crc,     &Statistics::bad_field};
// By MessageOutcome.
constexpr std::array<Counter, 5> kOutcomes{&Statistics::packets_ok, &Statistics::duplicate,
                                           &Statistics::late, &Statistics::bad_field,
                                           &Statistics::implausible};
// By Placed.
constexpr std::array<Counter, 4> kParts{&Statistics::packets_ok, &Statistics::unknown,
                                        &Statistics::duplicate, &Statistics::bad_field};
// By RawOutcome.
constexpr std::array<Counter, 6> kRaw{&Statistics::packets_ok, &Statistics::unknown,
                                      &Statistics::duplicate,  &Statistics::bad_field,
                                      &Statistics::late,       &Statistics::oversized};

std::size_t pixels(const wire::Header& header) {
  return std::size_t{header.image_width} * header.image_height;
}

}  // namespace

Reassembler::Reassembler(const ReassemblerOptions& options)
    : options_(options),
      session_(options.device_id),
      messages_(options.raw_pictures ? options.max_pixels : 0, options.serial_line) {}

void Reassembler::push(std::span<const std::byte> datagram, Time arrived, Time now) {
  const auto packet = wire::parse_packet(datagram);
  if (!packet) {
    ++(statistics_.*kFaults[static_cast<std::size_t>(packet.error())]);
    return;
  }
  if (is_signed() && !verify(datagram, packet->header.origin.session_id)) {
    return;
  }
  const wire::Header& header = packet->header;
  if (contradicts_itself(*packet)) {
    ++statistics_.bad_field;
    return;
  }
  const bool tells = tells_of_sensor(header.type);
  switch (session_.judge(header.origin, tells, is_signed(), arrived)) {
    case SessionTracker::Verdict::kForeign:
      ++(tells || session_.current() ? statistics_.foreign : statistics_.unknown);
      return;
    case SessionTracker::Verdict::kStarted:
      start_session();
      break;
    case SessionTracker::Verdict::kCurrent:
      break;
  }
  const bool part = wire::part_of_frame(header.type);
  const bool parity = header.type == wire::PacketType::kParity;
  if ((part || parity) && now - arrived > max_age()) {
    refuse_old(header, arrived);
  } else if (part) {
    push_part(*packet, arrived);
  } else if (parity) {
    push_parity(*packet, arrived);
  } else {
    push_report(*packet, arrived);
  }
}

bool Reassembler::verify(std::span<const std::byte> datagram, std::uint32_t session) {
  using Verdict = StreamVerifier::Verdict;
  switch (const Verdict verdict = options_.verifier->judge(datagram, session); verdict) {
    case Verdict::kGood:
      return true;
    case Verdict::kNotSigned:
    case Verdict::kKeyToCome:
      ++statistics_.not_signed;
      forgeries_ += verdict == Verdict::kNotSigned && options_.verifier->has_key() ? 1U : 0U;
      return false;
    case Verdict::kForged:
      ++statistics_.forged;
      ++forgeries_;
      return false;
    case Verdict::kDuplicate:
    case Verdict::kLate:
      ++(verdict == Verdict::kLate ? statistics_.late : statistics_.duplicate);
      break;
  }
  return false;
}

// Its frame is not delivered, nor is one before it that is still open.
void Reassembler::refuse_old(const wire::Header& header, Time arrived) {
  ++statistics_.old;
  const FrameSequence::Verdict verdict = judge(header, arrived);
  if (verdict == FrameSequence::Verdict::kOver || verdict == FrameSequence::Verdict::kImplausible) {
    return;
  }
  const std::uint32_t number = header.frame.number;
  for (FrameSlot* slot = oldest(FrameSlot::State::kOpen);
       slot != nullptr && number_distance(slot->number(), number) < 0;
       slot = oldest(FrameSlot::State::kOpen)) {
    statistics_.frames_lost += sequence_.close(slot->number());
    drop(*slot, &Statistics::frames_old);
  }
  sequence_.begin(number, arrived);
  statistics_.frames_lost += sequence_.close(number);
  static_cast<void>(sequence_.advance(header.frame.freshness, arrived));  // fresh, and old by now
  FrameSlot* const open = oldest(FrameSlot::State::kOpen);
  if (open != nullptr && open->number() == number) {
    drop(*open, &Statistics::frames_old);
  } else {
    ++statistics_.frames_old;
  }
}

FrameSequence::Verdict Reassembler::judge(const wire::Header& header, Time arrived) {
  using Verdict = FrameSequence::Verdict;
  const Verdict verdict = sequence_.judge(header.frame, arrived);
  if (verdict == Verdict::kResynchronised) {
    drop_open();
    closed_.forget();
    ++statistics_.resynchronised;
  }
  if (verdict == Verdict::kResynchronised || verdict == Verdict::kImplausible) {
    pace_.interrupt();
  }
  // What was believed of the order is of no sensor, or two count.
  if (verdict == Verdict::kResynchronised || verdict == Verdict::kPassedOver) {
    forgeries_ += is_signed() ? 0U : 1U;
  }
  return verdict == Verdict::kPassedOver ? Verdict::kOver : verdict;
}

void Reassembler::drop(FrameSlot& slot, Counter cause) {
  slot.state = FrameSlot::State::kFree;
  ++(statistics_.*cause);
}

void Reassembler::drop_open() {
  for (FrameSlot& slot : slots_) {
    if (slot.state == FrameSlot::State::kOpen) {
      drop(slot, &Statistics::frames_dropped);
    }
  }
}

void Reassembler::push_report(const wire::PacketView& packet, Time arrived) {
  switch (packet.header.type) {
    case wire::PacketType::kCalibration:
      push_calibration(packet, arrived);
      break;
    case wire::PacketType::kHealth:
      count(messages_.push_health(packet, is_signed(), arrived));
      break;
    case wire::PacketType::kEvent: {
      bool overflow = false;
      count(messages_.push_event(packet, arrived, overflow));
      statistics_.events_dropped += overflow ? 1 : 0;
      break;
    }
    case wire::PacketType::kRawInfo:
    case wire::PacketType::kRawTile:
      ++(statistics_.*kRaw[static_cast<std::size_t>(raw().push(packet, arrived))]);
      break;
    default:
      ++statistics_.unknown;
      break;
  }
}

void Reassembler::push_calibration(const wire::PacketView& packet, Time arrived) {
  std::optional<Duration> period;
  count(messages_.push_calibration(packet, sequence_, arrived, period));
  if (period) {
    pace_.tell(*period);
  }
}

void Reassembler::count(MessageOutcome outcome) {
  ++(statistics_.*kOutcomes[static_cast<std::size_t>(outcome)]);
}

void Reassembler::start_session() {
  drop_open();
  ++statistics_.sessions;
  statistics_.events_dropped += messages_.restart(session_.outlasts());
  sequence_ = {};
  delay_.restart();
  closed_.forget();
  parity_ = false;
}

// Parts of one frame that contradict each other have two senders.
bool Reassembler::count(Placed placed) {
  forgeries_ += placed == Placed::kContradicting ? 1U : 0U;
  ++(statistics_.*kParts[static_cast<std::size_t>(placed)]);
  return placed == Placed::kStored || placed == Placed::kIgnored;
}

void Reassembler::push_part(const wire::PacketView& packet, Time arrived) {
  const wire::Header& header = packet.header;
  if (pixels(header) > options_.max_pixels) {
    ++statistics_.oversized;
    return;
  }
  switch (judge(header, arrived)) {
    case FrameSequence::Verdict::kOver:
      refuse_closed(packet);
      return;
    case FrameSequence::Verdict::kImplausible:
      ++statistics_.implausible;
      return;
    default:
      break;
  }
  FrameSlot& slot = open(header, arrived);
  if (!count(slot.add(packet, arrived))) {
    return;
  }
  delay_.note(header.frame, arrived, is_signed() ? options_.verifier->good_number() : 0,
              2 * assumed_period() + max_age());
  if (header.type == wire::PacketType::kFrameInfo) {
    note_info(slot, arrived);
  } else if (slot.parity()) {
    repair(slot, slot.group_of(header.index), arrived);
  }
  close_if_complete(slot);
}

// It says whether there is parity; what waited for that is made now.
void Reassembler::note_info(FrameSlot& slot, Time now) {
  parity_ = !slot.told_no_parity();
  forgeries_ += slot.drop_false_parity() ? 1U : 0U;
  for (std::size_t group = 0; group < slot.parity_sums(); ++group) {
    repair(slot, group, now);
  }
}

void Reassembler::push_parity(const wire::PacketView& packet, Time arrived) {
  const Result<wire::ParityFields> fields = wire::decode_parity_fields(packet.payload);
  if (!fields || fields->count == 0) {
    ++statistics_.bad_field;
    return;
  }
  switch (judge(packet.header, arrived)) {
    case FrameSequence::Verdict::kOver:
      count_closed_parity(packet);
      return;
    case FrameSequence::Verdict::kImplausible:
      ++statistics_.implausible;
      return;
    default:
      break;
  }
  wire::Header part = packet.header;  // as one of the parts that are missing
  part.count = fields->count;
  FrameSlot& slot = open(part, arrived);
  if (!count(slot.add_parity(packet, arrived))) {
    return;
  }
  if (slot.parity()) {
    repair(slot, packet.header.index, arrived);
  }
  close_if_complete(slot);
}

// What parity makes good is judged like what arrives.
void Reassembler::repair(FrameSlot& slot, std::size_t group, Time now) {
  const std::optional<wire::PacketView> packet =
      slot.has_parity(group, parity_) ? slot.recover(group) : std::nullopt;
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

void Reassembler::refuse_closed(const wire::PacketView& packet) {
  using Verdict = ClosedFrames::Verdict;
  const Verdict verdict = closed_.judge_part(packet);
  if (verdict == Verdict::kForgotten) {
    pace_.interrupt();
  }
  if (verdict == Verdict::kContradicting || sequence_.contradicts(packet)) {
    count(Placed::kContradicting);
  } else {
    ++(verdict == Verdict::kRepeated ? statistics_.duplicate : statistics_.late);
  }
}

void Reassembler::count_closed_parity(const wire::PacketView& packet) {
  switch (closed_.judge_parity(packet)) {
    case ClosedFrames::Verdict::kContradicting:
      count(Placed::kContradicting);
      break;
    case ClosedFrames::Verdict::kRepeated:
      ++statistics_.duplicate;
      break;
    case ClosedFrames::Verdict::kInOrder:
      ++statistics_.packets_ok;
      break;
    default:
      ++statistics_.late;
      break;
  }
}

// The slot of this packet's frame, begun when it is the frame's first.
FrameSlot& Reassembler::open(const wire::Header& header, Time now) {
  const std::uint32_t number = header.frame.number;
  for (FrameSlot& slot : slots_) {
    if (slot.state == FrameSlot::State::kOpen && slot.number() == number) {
      return slot;
    }
  }
  if (sequence_.begin(number, now)) {
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
  slot->begin(header, parity_, now);
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
  statistics_.frames_lost += sequence_.close(number);
  statistics_.packets_missing += slot.missing_packets();
  sequence_.remember(slot.packets().mark(number));
  if (slot.missing_packets() == slot.count()) {
    sequence_.pass(number, slot.last_packet());
  }
  closed_.add(slot);
  if (!sequence_.advance(slot.freshness(), slot.last_packet())) {
    pace_.interrupt();
    drop(slot, &Statistics::frames_stale);
    return;
  }
  pace_.note(slot.last_packet(), slot.made_with());
  messages_.note_frame(number, slot.made_with(), slot.depth_size(), slot.last_packet());
  if (comes_late(slot)) {
    ++late_frames_;
    drop(slot, &Statistics::frames_old);
    return;
  }
  slot.finish();
  slot.choose_calibration(messages_.lenses());
  slot.order = ++finished_;
  slot.state = FrameSlot::State::kFinished;
}

bool Reassembler::comes_late(const FrameSlot& slot) {
  const FrameDelay::Verdict verdict =
      delay_.judge(slot.stamp(), slot.last_packet(), max_age(), is_signed());
  statistics_.resynchronised += verdict == FrameDelay::Verdict::kResynchronised ? 1 : 0;
  return verdict == FrameDelay::Verdict::kLate;
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

std::optional<Frame> Reassembler::take(Time now) {
  for (FrameSlot& slot : slots_) {
    if (slot.state == FrameSlot::State::kFinished && now - slot.last_packet() > max_age()) {
      drop(slot, &Statistics::frames_old);
    }
  }
  return take();
}

bool Reassembler::keep(FramePixels& pixels) noexcept {
  for (FrameSlot& slot : slots_) {
    if (slot.state == FrameSlot::State::kOut) {
      slot.swap_pixels(pixels);
      slot.state = FrameSlot::State::kFree;
      return true;
    }
  }
  return false;
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

Duration Reassembler::period() const {
  // What is signed nobody else tells.
  return is_signed() ? pace_.told() : pace_.believed();
}

Duration Reassembler::frame_timeout() const {
  if (options_.frame_timeout) {
    return *options_.frame_timeout;
  }
  return std::clamp(period() + period() / 2, kShortestTimeout, kLongestTimeout);
}

Duration Reassembler::assumed_period() const {
  return period() > Duration(0) ? period() : kUnknownPeriod;
}

Duration Reassembler::max_age() const {
  const Duration assumed = assumed_period();
  const Duration expired = assumed + assumed / 2 + kAgeBeyondPeriod / 2;
  return options_.max_age.value_or(std::max(assumed + kAgeBeyondPeriod, expired));
}

std::optional<Time> Reassembler::next_expiry() const {
  std::optional<Time> first = messages_.raw().next_expiry();
  for (const FrameSlot& slot : slots_) {
    if (slot.state == FrameSlot::State::kOpen) {
      const Time expiry = slot.last_packet() + frame_timeout();
      first = first ? std::min(*first, expiry) : expiry;
    }
  }
  return first;
}

void Reassembler::expire(Time now) {
  raw().expire(now);
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
