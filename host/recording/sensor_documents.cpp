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

std::uint32_t fingerprint_of_file(const std::string& file) {
  return wire::calibration_fingerprint(std::as_bytes(std::span(file)));
}

}  // namespace

std::uint32_t fingerprint_of(const std::string& document) {
  return wire::crc32c(std::as_bytes(std::span(document)));
}

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
    keep_settings(fingerprint_of(documents.settings), documents.settings);
  }
  if (!documents.calibration.empty()) {
    known_calibrations_.insert(fingerprint_of_file(documents.calibration));
  }
}

void DocumentWatch::keep_settings(std::uint32_t fingerprint, std::string document) {
  if (known_settings_.size() >= kMostSettings) {
    known_settings_.clear();
  }
  known_settings_[fingerprint] = std::move(document);
}

std::string DocumentWatch::settings(std::uint32_t fingerprint) const {
  const auto known = known_settings_.find(fingerprint);
  return known == known_settings_.end() ? std::string() : known->second;
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
    const std::uint32_t fingerprint = fingerprint_of(documents.settings);
    if (settings(fingerprint).empty()) {
      keep_settings(fingerprint, documents.settings);
    } else {
      documents.settings.clear();
    }
    documents.no_settings = "they changed again before they could be read";
  }
  if (!documents.calibration.empty()) {
    const bool fresh =
        known_calibrations_.insert(fingerprint_of_file(documents.calibration)).second;
    documents.calibration = fresh ? std::move(documents.calibration) : std::string();
  }
  // What was changed again meanwhile nobody gives any more; nor is a silent sensor asked forever.
  if (wanted_settings_ == 0 || known_settings_.contains(wanted_settings_)) {
    documents.no_settings.clear();
  } else {
    keep_settings(wanted_settings_, {});
  }
  known_calibrations_.insert(wanted_calibration_);
  return documents;
}

}  // namespace stof::recording
