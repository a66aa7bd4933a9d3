#include "host/cli/view/page_settings.h"

#include <algorithm>
#include <utility>

#include "host/cli/config/settings_text.h"
#include "host/cli/failure.h"
#include "host/cli/own_keys.h"
#include "host/cli/sensor/find_sensor.h"
#include "host/client/control/known_sensors.h"
#include "host/client/control/user_keys.h"

namespace stof::host {
namespace {

std::string over(const ShownSensor& sensor, const ConfigOptions& options,
                 const std::vector<std::string>& words) {
  if (sensor.address.empty()) {
    throw Failure(Exit::kFailure, "no frame has come: nobody knows where the sensor is");
  }
  ConfigOptions meant = options;
  meant.sensor = sensor.address;
  return config_over(value_or_fail(client::open_udp_transport(sensor_address(sensor.address))),
                     words, meant);
}

std::string first_line(const std::string& text) {
  std::string line = text;
  std::ranges::replace(line, '\n', ' ');
  line.erase(line.find_last_not_of(' ') + 1);
  return line;
}

const char* name_of(wire::Role role) {
  switch (role) {
    case wire::Role::kView:
      return "view";
    case wire::Role::kTune:
      return "tune";
    case wire::Role::kAdmin:
      return "admin";
    default:
      return "none";
  }
}

}  // namespace

// Whose keys count is what `stof config` would say.
OwnRole own_role(const ShownSensor& sensor, const ConfigOptions& options) {
  const client::Meant meant =
      meant_or_fail(options.keys, value_or_fail(client::read_user_keys(options.keys)),
                    sensor.address, {.device = options.device, .key_id = key_id_of(options.key)});
  OwnRole own{.role = sensor.unpaired ? "anybody" : "none", .doubt = meant.doubt};
  for (const wire::Key& key : meant.keys.all()) {  // the newest comes last
    if (key.device == sensor.device) {
      own.role = name_of(key.role);
    }
  }
  return own;
}

viewer::SettingsState read_settings(const ShownSensor& sensor, const ConfigOptions& options) {
  viewer::SettingsState state;
  const auto document = [&](const char* name) {
    ConfigOptions one = options;
    one.document = name;
    return over(sensor, one, {"get"});
  };
  try {
    state.schema = over(sensor, options, {"schema"});
    state.active = document("active");
    state.saved = document("saved");
    state.defaults = document("defaults");
    OwnRole own = own_role(sensor, options);
    state.role = std::move(own.role);
    state.doubt = std::move(own.doubt);
  } catch (const Failure& failure) {
    state.problem = failure.what();
  }
  return state;
}

std::string change_settings(const ShownSensor& sensor, const ConfigOptions& options,
                            const std::vector<std::string>& assignments) {
  // More would be staged and committed, and so be saved unasked.
  if (settings_pieces(settings_from_words(assignments), client::ControlClient::kMaxText).size() >
      1) {
    throw Failure(Exit::kBadInput, "too many changes for one request: apply some of them first");
  }
  std::vector<std::string> words{"set"};
  words.insert(words.end(), assignments.begin(), assignments.end());
  ConfigOptions meant = options;
  const OwnRole own = own_role(sensor, options);
  meant.may_save = own.doubt.empty() && (own.role == "admin" || own.role == "tune");
  return first_line(over(sensor, meant, words));
}

std::string save_settings(const ShownSensor& sensor, const ConfigOptions& options) {
  return first_line(over(sensor, options, {"save"}));
}

}  // namespace stof::host
