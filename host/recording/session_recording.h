#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "host/client/raw/raw_exposure.h"
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
  // The two that follow: not before begun(). `from`: whose they are; after a restart they come
  // before a frame does. None: of the session of the last frame.
  void take(const wire::EventReport& event, const std::optional<wire::Origin>& from = {});
  void take(const std::optional<wire::HealthReport>& health,
            const std::optional<wire::Origin>& from = {});
  // Settings that are still asked for, at the end: waits for them.
  void finish() { take_documents(true); }

  // An exposure that is recorded has come.
  bool raw_begun() const { return raw_begun_; }
  bool begun() const { return origin_.has_value(); }  // a frame has come
  std::uint64_t frames() const { return frames_; }
  std::uint64_t dropped() const { return dropped_; }  // frames and exposures, by a slow disk
  std::uint64_t exposures() const { return exposures_; }
  std::uint64_t lost_pictures() const { return lost_pictures_; }  // exposures that miss some

 private:
  void take_documents(bool wait);
  void put_settings(const std::string& document, std::uint64_t time);
  void put_calibration(const std::string& file, std::uint64_t time);
  void put_sensor(const client::Frame& frame, const std::string& place, std::uint64_t time);

  Recorder& recorder_;
  Options options_;
  SensorDocuments documents_;
  DocumentWatch watch_;
  LogClock clock_;
  std::optional<wire::Origin> origin_;  // of the session that is recorded
  std::optional<wire::CalibrationPacket> calibration_;
  std::optional<std::uint64_t> uptime_ms_;  // of the health that was recorded last
  std::uint32_t health_session_ = 0;        // likewise
  bool raw_begun_ = false;                  // in this session
  std::uint64_t exposures_ = 0;
  std::uint64_t lost_pictures_ = 0;
  std::uint64_t frames_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace stof::recording
