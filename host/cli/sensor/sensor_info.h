#pragma once

#include <expected>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "firmware/wire/messages/calibration.h"
#include "firmware/wire/messages/health.h"
#include "host/cli/receive.h"
#include "host/cli/recording/sensor_documents.h"
#include "host/cli/sensor/health.h"
#include "host/discovery/found_sensors.h"

namespace stof::host {

// What a sensor that runs is, and what it sends.
struct SensorInfo {
  std::string place{};
  // None: it does not say who it is, as a replay. With --signed its serial number and its name are
  // proven, and nothing else of it.
  std::optional<client::FoundSensor> identity{};
  std::string no_identity{};  // why
  bool is_signed = false;
  std::uint32_t device_id = 0;
  std::string streams{};  // of a frame, as `stof view` says
  const char* clock = "unknown";
  std::uint32_t settings_revision = 0;
  std::uint32_t settings_fingerprint = 0;
  std::optional<wire::CalibrationPacket> calibration{};
  std::optional<HealthState> health{};
  recording::SensorDocuments documents{};  // settings
};

// Asks it for that, for the timeout of the options where it `sends`, a second where nobody knows.
// device: that sends, who alone counts. The error: why it is not told.
std::expected<client::FoundSensor, std::string> ask_identity(const ReceiveOptions& options,
                                                             bool sends,
                                                             std::optional<std::uint32_t> device);

// Subscribes for a second or two. Throws Failure where no frame comes.
SensorInfo read_sensor_info(const ReceiveOptions& options);

std::string sensor_info_text(const SensorInfo& info);
nlohmann::ordered_json sensor_info_json(const SensorInfo& info);

// Of a calibration as it is sent, for `stof info`.
std::string calibration_line(const wire::CalibrationPacket& one);
nlohmann::ordered_json calibration_json(const wire::CalibrationPacket& one);

}  // namespace stof::host
