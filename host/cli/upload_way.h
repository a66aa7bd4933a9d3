#pragma once

#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "host/cli/control_flags.h"
#include "host/cli/own_keys.h"
#include "host/client/control/upload_client.h"

namespace stof::host {

// The way of an upload to one sensor, with a key of this user or over the cable: `stof calib
// install`, `stof update`.
struct UploadWay {
  std::string place;  // for messages
  client::ControlClient sensor;
  client::UploadClient uploads;
  std::string key_file;
  std::string named;  // as the user wrote it; empty: the cable

  UploadWay(std::unique_ptr<client::ControlTransport> transport,
            const client::ControlOptions& control, client::Duration patience)
      : place(transport->place()),
        sensor(std::move(transport), control),
        uploads(sensor, patience) {}

  // The sensor that has proven who it is, else the place.
  std::string who() const;
  // "device_id", null where none was proven, and "place".
  nlohmann::ordered_json json() const;
  // Keeps where the sensor was proven to be.
  void remember() const;
};

// sensor: HOST[:PORT]; empty with flags.serial. Throws Failure.
std::unique_ptr<UploadWay> open_upload_way(const char* command, const std::string& sensor,
                                           const ControlFlags& flags, double patience_s);

// Of a refusal. Throws Failure: bad input where what was sent is no good.
[[noreturn]] void refuse_upload(const client::UploadResult& answer, const std::string& place);

}  // namespace stof::host
