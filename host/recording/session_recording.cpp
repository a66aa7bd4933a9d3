#include "host/recording/session_recording.h"

#include <utility>

#include "firmware/wire/frame/raw_packets.h"
#include "host/client/value_names.h"
#include "host/recording/told_lenses.h"

namespace stof::recording {

SessionRecording::SessionRecording(Recorder& recorder, Options options, SensorDocuments documents)
    : recorder_(recorder),
      options_(std::move(options)),
      documents_(std::move(documents)),
      watch_(options_.read, options_.raw) {}

void SessionRecording::take(const client::Frame& frame, const std::string& place) {
  const std::uint64_t time = clock_.at(frame.last_packet);
  if (!origin_ || origin_->session_id != frame.origin.session_id) {
    origin_ = frame.origin;
    calibration_.reset();
    raw_begun_ = false;
    put_sensor(frame, place, time);
  }
  TopicMessages messages;
  if (frame.calibration && frame.calibration != calibration_) {
    calibration_ = frame.calibration;
    append_calibration(messages, frame, time);
  } else if (!frame.calibration && frame.info && calibration_ &&
             calibration_->fingerprint == frame.info->calibration_fingerprint &&
             calibration_->fingerprint != 0) {
    calibration_ = taken_back(*calibration_);
    client::Frame beside = frame;
    beside.calibration = calibration_;
    append_calibration(messages, beside, time);
  }
  if (frame.info) {
    watch_.note(frame.info->settings_fingerprint, frame.info->calibration_fingerprint);
  }
  append_frame(messages, frame, time);
  if (recorder_.put(std::move(messages))) {
    ++frames_;
  } else if (!recorder_.failed()) {
    ++dropped_;
    calibration_.reset();  // it may have been among them
  }
}

bool SessionRecording::counts(const client::RawExposure& exposure) {
  raw_begun_ = raw_begun_ || (exposure.info.state & wire::kRawBegunAnew) != 0;
  return raw_begun_ && origin_ && origin_->session_id == exposure.origin.session_id;
}

void SessionRecording::take(const client::RawExposure& exposure) {
  if (!counts(exposure)) {
    return;
  }
  TopicMessages messages;
  append_raw(messages, exposure, clock_.at(exposure.last_packet));
  if (recorder_.put(std::move(messages))) {
    ++exposures_;
    lost_pictures_ += exposure.complete() ? 0U : 1U;
  } else if (!recorder_.failed()) {
    ++dropped_;
  }
}

void SessionRecording::take(const wire::EventReport& event,
                            const std::optional<wire::Origin>& from) {
  TopicMessages messages;
  append_event(messages, from.value_or(*origin_), event, clock_.now());
  recorder_.put(std::move(messages));
}

void SessionRecording::take(const std::optional<wire::HealthReport>& health,
                            const std::optional<wire::Origin>& from) {
  take_documents(false);
  const wire::Origin origin = from.value_or(*origin_);
  if (health && (health->uptime_ms != uptime_ms_ || origin.session_id != health_session_)) {
    uptime_ms_ = health->uptime_ms;
    health_session_ = origin.session_id;
    TopicMessages messages;
    append_health(messages, origin, *health, clock_.now());
    recorder_.put(std::move(messages));
  }
}

// Settings and calibration that changed meanwhile.
void SessionRecording::take_documents(bool wait) {
  const std::optional<SensorDocuments> documents = watch_.take(wait);
  if (!documents) {
    return;
  }
  if (!documents->settings.empty()) {
    put_settings(documents->settings, clock_.now());
  }
  if (!documents->calibration.empty()) {
    put_calibration(documents->calibration, clock_.now());
  }
}

void SessionRecording::put_settings(const std::string& document, std::uint64_t time) {
  TopicMessages messages;
  append_settings(messages, document, time);
  recorder_.put(std::move(messages));
}

void SessionRecording::put_calibration(const std::string& file, std::uint64_t time) {
  OwnedAttachment attachment{
      .name = kCalibrationAttachment, .media_type = "application/octet-stream", .log_time = time};
  mcap::append_bytes(attachment.data, mcap::bytes_of(file));
  recorder_.put(std::move(attachment));
}

// Metadata of the session, and the settings that it began with.
void SessionRecording::put_sensor(const client::Frame& frame, const std::string& place,
                                  std::uint64_t time) {
  mcap::Metadata metadata{
      .name = kSensorMetadata,
      .entries = {{"program", options_.program},
                  {"device_id", std::to_string(frame.origin.device_id)},
                  {"session_id", std::to_string(frame.origin.session_id)},
                  {"sensor", options_.sensor},
                  {"place", place},
                  {"signed", options_.is_signed ? "yes" : "no"},
                  {"sensor_clock", client::clock_text(frame.stamp.clock)},
                  {"log_time",
                   "wall clock of the recording computer at the start, which goes on "
                   "by its monotonic clock"},
                  {"settings", documents_.settings.empty()
                                   ? documents_.no_settings
                                   : std::string("attachment ") + kSettingsAttachment}}};
  if (options_.raw) {
    metadata.entries["calibration"] = documents_.calibration.empty()
                                          ? documents_.no_calibration
                                          : std::string("attachment ") + kCalibrationAttachment;
  }
  recorder_.put(std::move(metadata));
  watch_.know(documents_);
  if (!documents_.calibration.empty()) {
    put_calibration(documents_.calibration, time);
  }
  if (!documents_.settings.empty()) {
    put_settings(documents_.settings, time);
    OwnedAttachment attachment{
        .name = kSettingsAttachment, .media_type = "application/json", .log_time = time};
    mcap::append_bytes(attachment.data, mcap::bytes_of(documents_.settings));
    recorder_.put(std::move(attachment));
  }
  documents_ = {.no_settings = "of an earlier session: see its attachment",
                .no_calibration = "of an earlier session: see its attachment"};
}

}  // namespace stof::recording
