#include "host/client/session/session_messages.h"

#include <utility>

#include "firmware/wire/calibration/calibration_packet.h"
#include "host/client/frame/frame_slot.h"
#include "host/client/session/frame_pace.h"

namespace stof::client {
namespace {

constexpr std::int32_t kWindow = 64;           // sequences that are told apart
constexpr std::int32_t kMostEvents = 1 << 16;  // that were all lost in a row
// An event is sent again after a second.
constexpr Duration kRepetition = std::chrono::milliseconds(500);

constexpr std::uint64_t kUptimeSlackMs = 2000;
constexpr Duration kHealthSilence = std::chrono::milliseconds(2500);  // one a second is sent

// Whether an uptime follows one that was told at `then`.
bool follows(std::uint64_t uptime_ms, std::uint64_t before_ms, Time then, Time now) noexcept {
  const std::int64_t elapsed_ms = now <= then ? 0 : (now - then) / std::chrono::milliseconds(1);
  const std::uint64_t most = static_cast<std::uint64_t>(elapsed_ms + elapsed_ms / 16);
  return uptime_ms >= before_ms && uptime_ms - before_ms <= most + kUptimeSlackMs;
}

bool is_period(std::int64_t period_ns) noexcept {
  return period_ns >= 0 && std::chrono::nanoseconds(period_ns) <= FramePace::kLongest;
}

// Whether both may be said of one rig, or are of two: settings change the range and the period, and
// one picture in place of another on a serial line its size and its unit.
bool same_rig(const wire::CalibrationPacket& one, const wire::CalibrationPacket& other) noexcept {
  if (one.fingerprint != other.fingerprint || one.fingerprint == 0 ||
      one.image_width != other.image_width || one.image_height != other.image_height ||
      one.depth_unit_um != other.depth_unit_um) {
    return true;
  }
  wire::CalibrationPacket compared = one;
  compared.max_range = other.max_range;
  compared.period_ns = other.period_ns;
  return compared == other;
}

}  // namespace

std::size_t SessionMessages::restart() {
  const std::size_t untaken = events_in_ - events_out_;
  raw_.restart();
  RawAssembler raw = std::move(raw_);  // its counts are the receiver's
  const std::uint64_t lies = lies_;
  *this = SessionMessages();
  raw_ = std::move(raw);
  lies_ = lies;
  return untaken;
}

MessageOutcome SessionMessages::push_calibration(const wire::PacketView& packet,
                                                 const FrameSequence& frames, Time arrived) {
  const Result<wire::CalibrationPacket> decoded = wire::read_calibration_packet(packet.payload);
  if (!decoded) {
    return MessageOutcome::kContradicting;
  }
  const std::uint32_t number = packet.header.frame.number;
  if (!frames.plausible(number, arrived) || !is_period(decoded->period_ns)) {
    return MessageOutcome::kImplausible;
  }
  const bool ordered = calibration_ && frames.plausible(calibration_frame_, arrived);
  if (ordered && number_distance(number, calibration_frame_) < 0) {
    return MessageOutcome::kLate;
  }
  if (contradicts(*decoded, arrived)) {
    return MessageOutcome::kImplausible;
  }
  keep(*decoded);
  calibration_frame_ = number;
  calibration_at_ = arrived;
  return MessageOutcome::kTaken;
}

// The known one may be the lie: then it is not sent again, and this one is.
bool SessionMessages::contradicts(const wire::CalibrationPacket& calibration, Time arrived) {
  if (!calibration_ || same_rig(calibration, *calibration_)) {
    doubted_.reset();
    return false;
  }
  const bool again = doubted_ && doubted_->calibration == calibration;
  if (again && arrived - doubted_->at >= kRepetition) {
    doubted_.reset();
    return false;
  }
  if (!again) {
    doubted_ = Doubted{.calibration = calibration, .at = arrived};
  }
  return true;
}

void SessionMessages::keep(const wire::CalibrationPacket& calibration) {
  if (calibration_ && *calibration_ != calibration) {
    const bool returns = made_ && former_ && former_->calibration == calibration;
    lies_ += returns && former_->made == made_ ? 1U : 0U;
    former_ = Former{.calibration = *calibration_, .made = made_};
  }
  calibration_ = calibration;
}

// Health goes on while no frame is sent: its order is that of the uptime.
MessageOutcome SessionMessages::push_health(const wire::PacketView& packet, Time arrived) {
  const Result<wire::HealthReport> decoded = wire::decode_health_report(packet.payload);
  if (!decoded) {
    return MessageOutcome::kContradicting;
  }
  if (!believes_uptime(decoded->uptime_ms, arrived)) {
    refused_health_ = {.value = decoded->uptime_ms, .at = arrived};
    return decoded->uptime_ms < health_->uptime_ms ? MessageOutcome::kLate
                                                   : MessageOutcome::kImplausible;
  }
  health_ = *decoded;
  health_at_ = arrived;
  refused_health_.reset();
  return MessageOutcome::kTaken;
}

bool SessionMessages::believes_uptime(std::uint64_t uptime_ms, Time arrived) const noexcept {
  if (!health_ || follows(uptime_ms, health_->uptime_ms, health_at_, arrived)) {
    return true;
  }
  return arrived - health_at_ >= kHealthSilence && refused_health_ &&
         uptime_ms > refused_health_->value &&
         follows(uptime_ms, refused_health_->value, refused_health_->at, arrived);
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
  if (seen(event->sequence)) {
    return MessageOutcome::kTaken;
  }
  if (ahead > 0) {
    older_events_ = ahead < kWindow ? older_events_ << ahead : 0;
    newest_event_ = event->sequence;
  }
  older_events_ |= std::uint64_t{1} << (newest_event_ - event->sequence);
  if (events_in_ - events_out_ == kEvents) {
    ++events_out_;
    overflow = true;
  }
  events_[events_in_++ % kEvents] = *event;
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

std::optional<wire::EventReport> SessionMessages::take_event() {
  if (events_out_ == events_in_) {
    return std::nullopt;
  }
  return events_[events_out_++ % kEvents];
}

}  // namespace stof::client
