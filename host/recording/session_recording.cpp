#include "host/recording/session_recording.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include "firmware/wire/frame/raw_packets.h"
#include "host/client/value_names.h"
#include "host/recording/told_lenses.h"

namespace stof::recording {
namespace {

std::string fingerprint_text(std::uint32_t fingerprint) {
  std::array<char, 9> text{};
  std::snprintf(text.data(), text.size(), "%08x", fingerprint);
  return text.data();
}

}  // namespace

SessionRecording::SessionRecording(Recorder& recorder, Options options, SensorDocuments documents)
    : recorder_(recorder),
      options_(std::move(options)),
      documents_(std::move(documents)),
      watch_(options_.read, options_.raw) {}

void SessionRecording::take(const client::Frame& frame, const std::string& place) {
  const std::uint64_t time = clock_.at(frame.last_packet);
  if (!origin_) {
    first_frame_ = frame.last_packet;
  }
  if (!origin_ || origin_->session_id != frame.origin.session_id) {
    origin_ = frame.origin;
    calibration_.reset();
    settings_ = 0;
    raw_begun_ = false;
    watch_.forget_unread();
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
    follow_settings(frame.info->settings_fingerprint, time);
    watch_.note(frame.info->settings_fingerprint, frame.info->calibration_fingerprint);
  }
  append_frame(messages, frame, time);
  if (recorder_.put(std::move(messages))) {
    ++counts_.frames;
  } else if (!recorder_.failed()) {
    ++counts_.dropped;
    calibration_.reset();  // it may have been among them
  }
  put_early_health();
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
    ++counts_.exposures;
    counts_.lost_pictures += exposure.complete() ? 0U : 1U;
  } else if (!recorder_.failed()) {
    ++counts_.dropped;
  }
}

void SessionRecording::take(const client::ToldEvent& event) {
  TopicMessages messages;
  append_event(messages, event.from, event.report, log_time(event.arrived));
  recorder_.put(std::move(messages));
}

void SessionRecording::take(const client::ToldHealth& health) {
  if (!begun() || health.arrived < first_frame_) {
    early_health_ = health;
    return;
  }
  put_early_health();
  put(health);
}

void SessionRecording::look(client::Receiver& receiver) {
  take_documents(false);
  // Where another session came in between it knows lenses no more, though none was taken back.
  const std::uint64_t sessions = receiver.statistics().sessions;
  if (std::exchange(sessions_, sessions) != sessions) {
    calibration_.reset();
  }
  while (const std::optional<client::ToldHealth> health = receiver.take_health()) {
    take(*health);
  }
  const bool forged = receiver.link().forged_traffic;
  if (!std::exchange(forged_, forged) && forged) {
    tell_forgery();
  }
}

void SessionRecording::put_early_health() {
  if (early_health_) {
    put(*std::exchange(early_health_, std::nullopt));
  }
}

void SessionRecording::put(const client::ToldHealth& health) {
  TopicMessages messages;
  append_health(messages, health.from, health.report, log_time(health.arrived));
  recorder_.put(std::move(messages));
}

std::uint64_t SessionRecording::log_time(client::Time arrived) const {
  return clock_.at(std::max(arrived, first_frame_));
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
  if (!documents->no_settings.empty()) {
    tell_unread_settings(documents->no_settings);
  }
}

// What is read already goes before the frame that was made with it: after a restart, and where
// settings are again what they were.
void SessionRecording::follow_settings(std::uint32_t fingerprint, std::uint64_t time) {
  if (fingerprint == 0 || fingerprint == settings_) {
    return;
  }
  if (const std::string document = watch_.settings(fingerprint); !document.empty()) {
    put_settings(document, time);
  }
}

// The first ones that a session misses, so that nobody can fill a disk with it.
void SessionRecording::tell_unread_settings(const std::string& reason) {
  constexpr const char* kUnread = "settings_not_read";
  if (!begun() || metadata_.entries.contains(kUnread)) {
    return;
  }
  metadata_.entries[kUnread] = fingerprint_text(watch_.wanted()) + ": " + reason;
  if (settings_ == 0) {
    metadata_.entries["settings"] = reason;
  }
  recorder_.put(mcap::Metadata(metadata_));
}

// The metadata of a session that begins later has it, too.
void SessionRecording::tell_forgery() {
  constexpr std::uint64_t kMostTold = 100;  // nobody can fill a disk with it
  ++forgeries_;
  if (begun() && forgeries_ <= kMostTold) {
    metadata_.entries[kForgedTraffic] = std::to_string(forgeries_);
    recorder_.put(mcap::Metadata(metadata_));
  }
}

void SessionRecording::put_settings(const std::string& document, std::uint64_t time) {
  TopicMessages messages;
  append_settings(messages, document, time);
  if (recorder_.put(std::move(messages))) {
    settings_ = fingerprint_of(document);
  }
}

void SessionRecording::put_calibration(const std::string& file, std::uint64_t time) {
  OwnedAttachment attachment{
      .name = kCalibrationAttachment, .media_type = "application/octet-stream", .log_time = time};
  mcap::append_bytes(attachment.data, mcap::bytes_of(file));
  recorder_.put(std::move(attachment));
}

// Where the settings are that a session began with.
std::string SessionRecording::settings_text(const client::Frame& frame) const {
  if (!documents_.settings.empty()) {
    return std::string("attachment ") + kSettingsAttachment;
  }
  const std::uint32_t fingerprint = frame.info ? frame.info->settings_fingerprint : 0;
  if (!watch_.settings(fingerprint).empty()) {
    return "fingerprint " + fingerprint_text(fingerprint) + ": on its topic";
  }
  return documents_.no_settings;
}

std::string SessionRecording::calibration_text(const client::Frame& frame) const {
  if (!documents_.calibration.empty()) {
    return std::string("attachment ") + kCalibrationAttachment;
  }
  const std::uint32_t fingerprint = frame.info ? frame.info->calibration_fingerprint : 0;
  if (watch_.knows_calibration(fingerprint)) {
    return "fingerprint " + fingerprint_text(fingerprint) + ": attached in an earlier session";
  }
  return documents_.no_calibration;
}

// Metadata of the session, and the settings that it began with.
void SessionRecording::put_sensor(const client::Frame& frame, const std::string& place,
                                  std::uint64_t time) {
  metadata_ = {.name = kSensorMetadata,
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
                           {"settings", settings_text(frame)}}};
  if (options_.raw) {
    metadata_.entries["calibration"] = calibration_text(frame);
  }
  if (forgeries_ != 0) {
    metadata_.entries[kForgedTraffic] = std::to_string(forgeries_);
  }
  recorder_.put(mcap::Metadata(metadata_));
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
  if (options_.read) {
    constexpr const char* kLater = "read while it was recorded: see its topic";
    documents_ = {.no_settings = kLater,
                  .no_calibration = "read while it was recorded: see its attachment"};
  }
}

}  // namespace stof::recording
