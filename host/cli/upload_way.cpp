#include "host/cli/upload_way.h"

#include <chrono>
#include <utility>

#include "host/cli/sensor/find_sensor.h"

namespace stof::host {

std::string UploadWay::who() const {
  return sensor.proven() ? "sensor " + std::to_string(sensor.proven()->device) : place;
}

nlohmann::ordered_json UploadWay::json() const {
  using Json = nlohmann::ordered_json;
  return {{"device_id", sensor.proven() ? Json(sensor.proven()->device) : Json(nullptr)},
          {"place", place}};
}

void UploadWay::remember() const {
  if (sensor.proven() && !named.empty()) {
    remember_place(key_file, {.named = named, .address = place}, sensor.proven()->key_id);
  }
}

std::unique_ptr<UploadWay> open_upload_way(const char* command, const std::string& sensor,
                                           const ControlFlags& flags, double patience_s) {
  const std::string file = keys_file(flags.keys);
  const client::ControlOptions control = control_of(file, sensor, flags);
  if (!sensor.empty() && flags.serial.empty()) {
    static_cast<void>(sensor_address(sensor));  // throws: too much to be told to a whole link
  }
  auto way = std::make_unique<UploadWay>(
      open_way(command, sensor, flags.serial, flags.baud), control,
      std::chrono::duration_cast<client::Duration>(std::chrono::duration<double>(patience_s)));
  check_called(way->sensor, sensor);
  way->key_file = file;
  way->named = sensor;
  return way;
}

void refuse_upload(const client::UploadResult& answer, const std::string& place) {
  using Result = wire::SettingsResult;
  std::string why = answer.text;
  if (answer.result == Result::kUnknownKey) {
    why = unknown_key_text(answer.text);
  } else if (why.empty()) {
    why = "does not know this request: update the sensor";
  }
  throw Failure(answer.result == Result::kInvalid ? Exit::kBadInput : Exit::kFailure,
                place + ": " + why);
}

}  // namespace stof::host
