#include "host/client/session/session_messages.h"

#include "firmware/wire/calibration/calibration_packet.h"
#include "host/client/frame/frame_slot.h"

namespace stof::client {
namespace {

constexpr std::int32_t kWindow = 64;  // sequences that are told apart

}  // namespace

std::size_t SessionMessages::restart() {
  const std::size_t untaken = events_in_ - events_out_;
  *this = {};
  return untaken;
}

MessageOutcome SessionMessages::push_calibration(const wire::PacketView& packet) {
  const Result<wire::CalibrationPacket> decoded = wire::read_calibration_packet(packet.payload);
  if (!decoded) {
    return MessageOutcome::kContradicting;
  }
  const std::uint32_t number = packet.header.frame.number;
  if (calibration_ && number_distance(number, calibration_frame_) < 0) {
    return MessageOutcome::kLate;
  }
  calibration_ = *decoded;
  calibration_frame_ = number;
  return MessageOutcome::kTaken;
}

// Health goes on while no frame is sent: its order is that of the uptime.
MessageOutcome SessionMessages::push_health(const wire::PacketView& packet) {
  const Result<wire::HealthReport> decoded = wire::decode_health_report(packet.payload);
  if (!decoded) {
    return MessageOutcome::kContradicting;
  }
  if (health_ && decoded->uptime_ms < health_->uptime_ms) {
    return MessageOutcome::kLate;
  }
  health_ = *decoded;
  return MessageOutcome::kTaken;
}

MessageOutcome SessionMessages::push_event(const wire::PacketView& packet, bool& overflow) {
  overflow = false;
  const Result<wire::EventReport> event = wire::decode_event_report(packet.payload);
  if (!event) {
    return MessageOutcome::kContradicting;
  }
  if (!event_seen_) {
    event_seen_ = true;
    newest_event_ = event->sequence;
    older_events_ = 0;
  }
  const std::int32_t ahead = number_distance(event->sequence, newest_event_);
  if (ahead <= -kWindow) {
    return MessageOutcome::kLate;
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
