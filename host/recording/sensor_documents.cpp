#include "host/recording/sensor_documents.h"

#include <chrono>
#include <span>
#include <utility>

#include "firmware/wire/calibration/calibration_file.h"
#include "firmware/wire/crc32c.h"
#include "host/client/control/download.h"

namespace stof::recording {
namespace {

bool ready(const std::future<SensorDocuments>& future) {
  return future.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

// By which frames name them.
std::uint32_t fingerprint_of(const std::string& document) {
  return wire::crc32c(std::as_bytes(std::span(document)));
}
std::uint32_t fingerprint_of_file(const std::string& file) {
  return wire::calibration_fingerprint(std::as_bytes(std::span(file)));
}

}  // namespace

SensorDocuments read_documents(client::ControlClient& sensor, bool calibration) {
  SensorDocuments documents;
  auto answer = sensor.request(wire::SettingsOperation::kGet, wire::SettingsDocument::kActive, {});
  if (answer) {
    documents.settings = std::move(answer->text);
  } else {
    documents.no_settings = answer.error().message;
    documents.no_calibration = answer.error().message;
  }
  if (calibration && answer) {
    auto file = client::download_calibration(sensor);
    if (file) {
      documents.calibration = std::move(*file);
    } else {
      documents.no_calibration = file.error().message;
    }
  }
  return documents;
}

void DocumentWatch::know(const SensorDocuments& documents) {
  if (!documents.settings.empty()) {
    known_settings_.insert(fingerprint_of(documents.settings));
  }
  if (!documents.calibration.empty()) {
    known_calibrations_.insert(fingerprint_of_file(documents.calibration));
  }
}

void DocumentWatch::note(std::uint32_t settings, std::uint32_t calibration) {
  const bool unknown_settings = settings != 0 && !known_settings_.contains(settings);
  const bool unknown_calibration =
      calibration_ && calibration != 0 && !known_calibrations_.contains(calibration);
  if (reading_.valid() || !read_ || !(unknown_settings || unknown_calibration)) {
    return;
  }
  tries_ = 0;
  wanted_settings_ = settings;
  wanted_calibration_ = calibration;
  reading_ = std::async(std::launch::async, read_, unknown_calibration);
}

std::optional<SensorDocuments> DocumentWatch::take(bool wait) {
  if (!reading_.valid() || (!wait && !ready(reading_))) {
    return std::nullopt;
  }
  constexpr int kTries = 5;
  SensorDocuments documents = reading_.get();
  while (documents.settings.empty() && ++tries_ < kTries) {
    reading_ = std::async(std::launch::async, read_, calibration_);
    if (!wait) {
      return std::nullopt;
    }
    documents = reading_.get();
  }
  if (!documents.settings.empty()) {
    const bool fresh = known_settings_.insert(fingerprint_of(documents.settings)).second;
    documents.settings = fresh ? std::move(documents.settings) : std::string();
  }
  if (!documents.calibration.empty()) {
    const bool fresh =
        known_calibrations_.insert(fingerprint_of_file(documents.calibration)).second;
    documents.calibration = fresh ? std::move(documents.calibration) : std::string();
  }
  // What was changed again meanwhile nobody gives any more; nor is a silent sensor asked forever.
  known_settings_.insert(wanted_settings_);
  known_calibrations_.insert(wanted_calibration_);
  return documents;
}

}  // namespace stof::recording
