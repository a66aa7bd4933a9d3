#include <optional>
#include <string>

#include "host/client/control/known_sensors.h"
#include "host/client/control/user_keys.h"
#include "host/lib/sensor.h"

using namespace stof;

namespace {

stof_status status_of(const client::ControlAnswer& answer) noexcept {
  switch (answer.result) {
    case wire::SettingsResult::kOk:
      return STOF_OK;
    case wire::SettingsResult::kUnsupported:
      return STOF_UNSUPPORTED;
    default:
      return STOF_REFUSED;
  }
}

stof_status status_of(Status status) noexcept {
  switch (status) {
    case Status::kTooLarge:
      return STOF_BAD_ARGUMENT;  // the text
    case Status::kTimeout:
      return STOF_UNREACHABLE;
    default:
      return lib::to_status(status);
  }
}

}  // namespace

// With the keys of the sensor that is meant; over a line without any.
std::optional<lib::Refusal> lib::open_control(stof_sensor& sensor) {
  client::ControlOptions options;
  if (sensor.device_id != 0) {
    options.device_id = sensor.device_id;
  }
  if (sensor.line) {
    options.unsigned_answers = client::Unsigned::kAlways;
    sensor.control =
        std::make_unique<client::ControlClient>(client::serial_transport(sensor.line), options);
    return std::nullopt;
  }
  if (!sensor.keys.empty()) {
    auto keys = client::read_user_keys(sensor.keys);
    if (!keys) {
      return lib::Refusal{keys.error().message, STOF_REFUSED};
    }
    auto meant = client::meant_sensor(sensor.keys, *keys, sensor.sensor,
                                      {.device = options.device_id, .key_id = sensor.key_id});
    if (!meant) {
      return lib::Refusal{meant.error().message, STOF_REFUSED};
    }
    options.keys = meant->keys;
    options.device_id = meant->device;
    options.doubt = meant->doubt;
    options.signed_alone = sensor.is_signed;
  }
  auto opened = client::ControlClient::open(sensor.sensor, options);
  if (!opened) {
    return lib::Refusal{opened.error().message, to_status(opened.error().status)};
  }
  sensor.control = std::make_unique<client::ControlClient>(std::move(*opened));
  return std::nullopt;
}

extern "C" {

stof_status stof_settings(stof_sensor* sensor, stof_operation operation, stof_document document,
                          const char* in, char* out, size_t out_size, stof_answer* answer) {
  lib::give_text("", out, out_size);
  if (sensor == nullptr || (answer != nullptr && answer->struct_size < sizeof(std::uint32_t))) {
    return STOF_BAD_ARGUMENT;
  }
  if (sensor->sensor.empty() && !sensor->line) {
    lib::give_text(sensor->played
                       ? "stof_settings: a recording is read: nobody is there to be asked"
                       : "stof_settings: name the sensor in stof_options::sensor",
                   out, out_size);
    return STOF_UNSUPPORTED;
  }
  return lib::guarded([&] {
    const std::scoped_lock lock(sensor->control_mutex);
    if (!sensor->control) {
      if (const std::optional<lib::Refusal> refusal = lib::open_control(*sensor)) {
        lib::give_text(refusal->text, out, out_size);
        return refusal->status;
      }
    }
    // What arrives may have values without a name here, so may what leaves.
    const auto got = sensor->control->request(static_cast<wire::SettingsOperation>(operation),
                                              static_cast<wire::SettingsDocument>(document),
                                              in == nullptr ? std::string_view{} : in);
    if (!got) {
      lib::give_text(got.error().message, out, out_size);
      if (got.error().status == Status::kDeviceLost) {
        sensor->control.reset();
      }
      return status_of(got.error().status);
    }
    if (got->result == wire::SettingsResult::kUnknownKey) {
      lib::give_text("the sensor has none of your keys: pair with it (stof pair)", out, out_size);
      sensor->control.reset();  // there may be another one next time
      return STOF_REFUSED;
    }
    lib::give_text(got->text, out, out_size);
    if (answer != nullptr) {
      stof_answer told{};
      told.revision = got->revision;
      told.restart = got->restart ? 1 : 0;
      told.text_length = got->text.size();
      static_cast<void>(lib::give(answer, told));
    }
    const stof_status status = status_of(*got);
    const bool cut = operation == STOF_GET && got->text.size() >= out_size;
    return status == STOF_OK && cut ? STOF_TOO_SMALL : status;
  });
}

}  // extern "C"
