#include "host/client/session/session_messages.h"

#include <array>
#include <cstddef>
#include <span>
#include <utility>

#include "firmware/wire/calibration/calibration_packet.h"
#include "host/client/frame/frame_slot.h"

namespace stof::client {
namespace {

constexpr std::int32_t kMostEvents = 1 << 16;  // that were all lost in a row
// An event is sent again after a second.
constexpr Duration kRepetition = std::chrono::milliseconds(500);

template <typename Report, std::size_t kBytes>
bool same_bytes(const Report& a, const Report& b,
                void (*encode)(const Report&, std::span<std::byte, kBytes>) noexcept) noexcept {
  std::array<std::array<std::byte, kBytes>, 2> bytes;
  encode(a, bytes[0]);
  encode(b, bytes[1]);
  return bytes[0] == bytes[1];
}

bool same(const wire::HealthReport& a, const wire::HealthReport& b) noexcept {
  return same_bytes(a, b, wire::encode_health_report);
}

bool same(const wire::EventReport& a, const wire::EventReport& b) noexcept {
  return same_bytes(a, b, wire::encode_event_report);
}

}  // namespace

std::size_t SessionMessages::restart(bool outlasts) {
  const std::size_t untaken = events_.clear();
  raw_.restart();
  RawAssembler raw = std::move(raw_);  // its counts are the receiver's
  const LensBook lenses = lenses_;
  const std::uint64_t lies = lies_;
  const HealthBook health = health_;
  const auto healths = healths_;
  *this = SessionMessages();
  raw_ = std::move(raw);
  lenses_ = lenses;
  lenses_.restart(outlasts);
  lies_ = lies;
  health_ = health;
  health_.restart();
  healths_ = healths;
  return untaken;
}

MessageOutcome SessionMessages::push_calibration(const wire::PacketView& packet,
                                                 const FrameSequence& frames, Time arrived,
                                                 std::optional<Duration>& period) {
  const Result<wire::CalibrationPacket> decoded = wire::read_calibration_packet(packet.payload);
  if (!decoded) {
    return MessageOutcome::kContradicting;
  }
  const std::uint32_t number = packet.header.frame.number;
  if (!frames.plausible(number, arrived) || !is_period(decoded->period_ns)) {
    return MessageOutcome::kImplausible;
  }
  // One that was sent beside a frame which is still to come may be a lie: it makes none late.
  const bool late = calibration_frame_ && !frames.ahead(*calibration_frame_) &&
                    number_distance(number, *calibration_frame_) < 0;
  if (!late) {
    period = std::chrono::nanoseconds(decoded->period_ns);
  }
  lies_ += beside_.take(number, *decoded) ? 0U : 1U;
  const bool believed = lenses_.take(*decoded, arrived, late);
  calibration_ = lenses_.current();
  if (!believed) {
    return MessageOutcome::kImplausible;
  }
  if (late) {
    return MessageOutcome::kLate;
  }
  calibration_frame_ = number;
  calibration_at_ =
      calibration_ && calibration_->fingerprint == decoded->fingerprint ? arrived : calibration_at_;
  return MessageOutcome::kTaken;
}

void SessionMessages::note_frame(std::uint32_t number, const std::optional<MadeWith>& made,
                                 ImageSize depth, Time arrived) noexcept {
  if (made) {
    lies_ += beside_.take(number, *made) ? 0U : 1U;
    lenses_.note_frame(*made, depth, arrived);
    calibration_ = lenses_.current();
  }
}

// Health goes on while no frame is sent: its order is that of the uptime.
MessageOutcome SessionMessages::push_health(const wire::PacketView& packet, bool is_signed,
                                            Time arrived) {
  const Result<wire::HealthReport> decoded = wire::decode_health_report(packet.payload);
  if (!decoded) {
    return MessageOutcome::kContradicting;
  }
  const std::optional<wire::HealthReport> before = health_.current();
  const HealthBook::Verdict verdict =
      is_signed ? health_.take_signed(*decoded, arrived) : health_.take(*decoded, arrived);
  if (!before || !same(*before, *health_.current())) {
    healths_.push({.report = *decoded, .from = packet.header.origin, .arrived = arrived});
  }
  switch (verdict) {
    case HealthBook::Verdict::kLate:
      return MessageOutcome::kLate;
    case HealthBook::Verdict::kImplausible:
      return MessageOutcome::kImplausible;
    case HealthBook::Verdict::kTaken:
      break;
  }
  return MessageOutcome::kTaken;
}

MessageOutcome SessionMessages::push_event(const wire::PacketView& packet, Time arrived,
                                           bool& overflow) {
  overflow = false;
  const Result<wire::EventReport> event = wire::decode_event_report(packet.payload);
  if (!event) {
    return MessageOutcome::kContradicting;
  }
  const auto outside = [&] {
    const std::int32_t ahead = number_distance(event->sequence, newest_event_);
    return ahead <= -kWindow || ahead > kMostEvents;
  };
  if (!event_seen_ || (outside() && repeats_refused_event(event->sequence, arrived))) {
    event_seen_ = true;
    newest_event_ = event->sequence;
    older_events_ = 0;
  }
  const std::int32_t ahead = number_distance(event->sequence, newest_event_);
  if (outside()) {
    return ahead < 0 ? MessageOutcome::kLate : MessageOutcome::kImplausible;
  }
  wire::EventReport& known = events_seen_[event->sequence % kWindow];
  if (seen(event->sequence)) {
    if (same(known, *event)) {
      return MessageOutcome::kTaken;
    }
    ++lies_;  // one of the two is somebody else's: whoever takes them gets both
  } else {
    health_.note_event(*event, arrived);
  }
  known = *event;
  if (ahead > 0) {
    older_events_ = ahead < kWindow ? older_events_ << ahead : 0;
    newest_event_ = event->sequence;
  }
  older_events_ |= std::uint64_t{1} << (newest_event_ - event->sequence);
  overflow = !events_.push({.report = *event, .from = packet.header.origin, .arrived = arrived});
  return MessageOutcome::kTaken;
}

bool SessionMessages::repeats_refused_event(std::uint32_t sequence, Time arrived) noexcept {
  if (refused_event_ && refused_event_->value == sequence) {
    return arrived - refused_event_->at >= kRepetition;
  }
  refused_event_ = {.value = sequence, .at = arrived};
  return false;
}

bool SessionMessages::seen(std::uint32_t sequence) const noexcept {
  const std::int32_t behind = number_distance(newest_event_, sequence);
  return behind >= 0 && ((older_events_ >> behind) & 1) != 0;
}

}  // namespace stof::client
