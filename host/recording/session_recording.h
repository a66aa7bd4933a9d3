#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "host/client/raw/raw_exposure.h"
#include "host/client/receiver.h"
#include "host/client/session/report_queue.h"
#include "host/recording/recorder.h"
#include "host/recording/sensor_documents.h"

namespace stof::recording {

// What one receiver gets, handed to a recorder as it comes: frames, what the sensor says beside
// them, and its settings and calibration, which are read again as they change. For one thread,
// which waits for nothing.
class SessionRecording {
 public:
  struct Options {
    std::string program{};   // name and version, for the file
    std::string sensor{};    // as its user named it, for the file
    bool is_signed = false;  // only what the sensor signs is received
    bool raw = false;        // raw exposures, too
    ReadDocuments read{};    // none: nobody can be asked
  };
  // documents: of the sensor now; empty ones are read when the first frame has come. The recorder
  // outlives it.
  SessionRecording(Recorder& recorder, Options options, SensorDocuments documents);

  // place: where the receiver has it from.
  void take(const client::Frame& frame, const std::string& place);
  // One that was computed from a known state, in the session that is recorded: the others do not
  // count.
  bool counts(const client::RawExposure& exposure);
  void take(const client::RawExposure& exposure);
  // Once the recording has begun.
  void take(const client::ToldEvent& event);
  // Of health that came before the first frame the newest counts. Reports of a new session come
  // before its first frame.
  void take(const client::ToldHealth& health);
  // The health that the receiver was told, and settings and calibration that were read meanwhile.
  // Look after each next(), before the frame is taken.
  void look(client::Receiver& receiver);
  // Settings that are still asked for, at the end: waits for them.
  void finish() { take_documents(true); }

  // An exposure that is recorded has come.
  bool raw_begun() const { return raw_begun_; }
  bool begun() const { return origin_.has_value(); }  // a frame has come
  std::uint64_t frames() const { return counts_.frames; }
  std::uint64_t dropped() const { return counts_.dropped; }
  std::uint64_t exposures() const { return counts_.exposures; }
  std::uint64_t lost_pictures() const { return counts_.lost_pictures; }

 private:
  struct Counts {
    std::uint64_t frames = 0;
    std::uint64_t exposures = 0;
    std::uint64_t lost_pictures = 0;  // exposures that miss some
    std::uint64_t dropped = 0;        // frames and exposures, by a slow disk
  };

  void take_documents(bool wait);
  void follow_settings(std::uint32_t fingerprint, std::uint64_t time);
  void tell_unread_settings(const std::string& reason);
  void tell_forgery();
  std::string settings_text(const client::Frame& frame) const;
  std::string calibration_text(const client::Frame& frame) const;
  void put_settings(const std::string& document, std::uint64_t time);
  void put_calibration(const std::string& file, std::uint64_t time);
  // Of the recording's clock; what came before the first frame is of that one's time.
  std::uint64_t log_time(client::Time arrived) const;
  void put(const client::ToldHealth& health);
  void put_early_health();
  void put_sensor(const client::Frame& frame, const std::string& place, std::uint64_t time);

  Recorder& recorder_;
  Options options_;
  SensorDocuments documents_;
  DocumentWatch watch_;
  LogClock clock_;
  std::optional<wire::Origin> origin_;  // of the session that is recorded
  mcap::Metadata metadata_;             // likewise
  std::uint32_t settings_ = 0;          // fingerprint of the newest document of the session
  std::optional<wire::CalibrationPacket> calibration_;
  client::Time first_frame_{};                      // of the recording, when it had come
  std::optional<client::ToldHealth> early_health_;  // the newest that came before it
  std::uint64_t sessions_ = 0;                      // that the receiver has seen
  bool forged_ = false;                             // LinkState::forged_traffic, when it was seen
  std::uint64_t forgeries_ = 0;                     // how often it began
  bool raw_begun_ = false;                          // in this session
  Counts counts_;
};

}  // namespace stof::recording
