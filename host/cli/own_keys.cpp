#include "host/cli/own_keys.h"

#include <array>
#include <charconv>
#include <chrono>
#include <cstdio>

#include "firmware/wire/crypto/crypto.h"
#include "host/cli/config/settings_text.h"
#include "host/cli/sensor/find_sensor.h"
#include "host/client/control/user_keys.h"
#include "host/client/printable.h"
#include "host/client/serial/serial_line.h"

namespace stof::host {

void need_crypto() {
  if (!wire::start_crypto()) {
    throw Failure(Exit::kFailure, "pair: this system has no random numbers");
  }
}

client::ControlOptions timing(double timeout_s) {
  return {.timeout = std::chrono::duration_cast<client::Duration>(
              std::chrono::duration<double>(timeout_s))};
}

std::unique_ptr<client::ControlTransport> open_way(const char* command, const std::string& sensor,
                                                   const std::string& serial, unsigned baud) {
  if (sensor.empty() == serial.empty()) {
    throw Failure(Exit::kBadInput,
                  std::string(command) + ": give a sensor, HOST[:PORT], or --serial");
  }
  return sensor.empty() ? value_or_fail(client::open_serial_transport(serial, baud))
                        : open_sensor(sensor);
}

client::ControlOptions control_of(const std::string& file, const std::string& sensor,
                                  const ControlFlags& flags) {
  client::ControlOptions control = timing(flags.timeout_s);
  control.keys = value_or_fail(client::read_user_keys(file));
  control.device_id = flags.device;
  if (!sensor.empty() || !flags.key.empty()) {
    const client::Meant meant = meant_or_fail(
        file, control.keys, sensor, {.device = flags.device, .key_id = key_id_of(flags.key)});
    control.keys = meant.keys;
    control.device_id = meant.device;
  }
  if (!control.device_id) {
    control.device_id = found_device(sensor);
  }
  if (!flags.serial.empty()) {
    control.unsigned_answers = client::Unsigned::kAlways;
  }
  return control;
}

std::vector<wire::Key> own_keys(const std::string& file, const wire::KeyTable& keys,
                                std::uint32_t device) {
  std::vector<wire::Key> own;
  for (std::size_t i = keys.count(); i-- > 0;) {
    if (keys.all()[i].device == device) {
      own.push_back(keys.all()[i]);
    }
  }
  if (own.empty()) {
    throw Failure(Exit::kBadInput, file + ": has no key of this sensor (" + std::to_string(device) +
                                       "): pair, or name its number with --device");
  }
  return own;
}

client::Meant meant_by(const std::string& file, const wire::KeyTable& keys,
                       const std::string& sensor, client::Asked asked) {
  if (!asked.device) {
    asked.device = serial_device(sensor);
  }
  return value_or_fail(client::meant_sensor(file, keys, sensor, asked));
}

client::Meant meant_or_fail(const std::string& file, const wire::KeyTable& keys,
                            const std::string& sensor, const client::Asked& asked) {
  client::Meant meant = meant_by(file, keys, sensor, asked);
  if (!meant.doubt.empty()) {
    throw Failure(Exit::kBadInput, (sensor.empty() ? file : sensor) + ": " + meant.doubt +
                                       " (--device NUMBER or --key ID)");
  }
  return meant;
}

void check_called(client::ControlClient& sensor, const std::string& called) {
  if (!is_sensor_name(called)) {
    return;
  }
  const auto answer = value_or_end(
      sensor.request(wire::SettingsOperation::kGet, wire::SettingsDocument::kActive, {}));
  const std::string name = name_in_settings(read_json(answer.text).value_or(Json()));
  if (answer.result == wire::SettingsResult::kOk && name != called) {
    throw Failure(Exit::kBadInput,
                  called + ": whoever answers as this sensor is called '" +
                      client::printable(name) +
                      "': somebody near announces what is not so, or it has just been renamed: "
                      "name the sensor that is meant by its serial number");
  }
}

void check_called(const std::string& called, client::ControlOptions control,
                  const wire::KeyTable& keys) {
  if (is_sensor_name(called)) {
    control.keys = keys;
    // Else whoever says that the key is unknown could say a name, too.
    control.signed_alone = keys.count() != 0;
    client::ControlClient sensor(open_sensor(called), control);
    check_called(sensor, called);
  }
}

std::uint32_t device_of(const client::Meant& meant) {
  return meant.device.value_or(meant.keys.count() == 0 ? 1 : meant.keys.all()[0].device);
}

std::string unknown_key_text(const std::string& told) {
  return told.empty() ? "has none of your keys: pair with it (stof pair)" : told;
}

std::string id_text(const wire::Key& key) {
  std::array<char, 9> text{};
  std::snprintf(text.data(), text.size(), "%08x", key.id);
  return text.data();
}

void remember_place(const std::string& key_file, const client::Place& place, std::uint32_t key_id) {
  if (const auto keys = client::read_user_keys(key_file)) {
    static_cast<void>(client::remember_sensor(key_file, *keys, place, key_id));
  }
}

std::uint32_t key_id_of(const std::string& text, const char* flag) {
  constexpr std::size_t kDigits = 8;
  std::uint32_t id = 0;
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, id, 16);
  if (!text.empty() && (text.size() != kDigits || read.ptr != end || id == 0)) {
    throw Failure(Exit::kBadInput,
                  std::string(flag) + ": takes the 8 hexadecimal digits of a key's id");
  }
  return id;
}

std::string keys_file(const std::string& named) {
  return named.empty() ? client::user_keys_file() : named;
}

}  // namespace stof::host
