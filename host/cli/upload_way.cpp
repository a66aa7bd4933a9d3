#include "host/cli/upload_way.h"

#include <chrono>
#include <utility>

#include "host/client/control/user_keys.h"

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
  const wire::KeyTable keys = value_or_fail(client::read_user_keys(file));
  client::ControlOptions control = timing(flags.timeout_s);
  control.keys = keys;
  control.device_id = flags.device;
  if (!sensor.empty() || !flags.key.empty()) {
    const client::Meant meant =
        meant_or_fail(file, keys, sensor, {.device = flags.device, .key_id = key_id_of(flags.key)});
    control.keys = meant.keys;
    control.device_id = meant.device;
  }
  if (!flags.serial.empty()) {
    control.unsigned_answers = client::Unsigned::kAlways;
  }
  auto way = std::make_unique<UploadWay>(
      open_way(command, sensor, flags.serial, flags.baud), control,
      std::chrono::duration_cast<client::Duration>(std::chrono::duration<double>(patience_s)));
  way->key_file = file;
  way->named = sensor;
  return way;
}

void refuse_upload(const client::UploadResult& answer, const std::string& place) {
  using Result = wire::SettingsResult;
  std::string why = answer.text;
  if (answer.result == Result::kUnknownKey) {
    why = "has none of your keys: pair with it (stof pair)";
  } else if (why.empty()) {
    why = "does not know this request: update the sensor";
  }
  throw Failure(answer.result == Result::kInvalid ? Exit::kBadInput : Exit::kFailure,
                place + ": " + why);
}

}  // namespace stof::host
