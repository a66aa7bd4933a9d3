#include "host/cli/discover.h"

#include <array>
#include <chrono>

#include <nlohmann/json.hpp>

#include "host/cli/failure.h"
#include "host/cli/help_text.h"
#include "host/cli/json_output.h"
#include "host/cli/output.h"
#include "host/client/value_names.h"
#include "host/discovery/discover.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr std::array kMethods{client::DiscoveryMethod::kDirect, client::DiscoveryMethod::kBeacon,
                              client::DiscoveryMethod::kMdns};

const char* health_name(const std::optional<wire::Health>& health) {
  return health ? client::name_in(client::kHealthNames, static_cast<std::size_t>(*health))
                : "unknown";
}

std::vector<std::string> methods_of(const client::FoundSensor& sensor) {
  std::vector<std::string> names;
  for (const client::DiscoveryMethod method : kMethods) {
    if (sensor.methods[static_cast<std::size_t>(method)]) {
      names.emplace_back(client::to_string(method));
    }
  }
  return names;
}

// Two rows of one serial number are rivals, too. sensors: in the order of their numbers.
void note_rivals(std::vector<client::FoundSensor>& sensors) {
  for (std::size_t i = 1; i < sensors.size(); ++i) {
    client::FoundSensor& one = sensors[i - 1];
    client::FoundSensor& other = sensors[i];
    if (one.serial == other.serial) {
      one.rival = one.rival.empty() ? other.endpoint() : one.rival;
      other.rival = one.endpoint();
    }
  }
}

}  // namespace

void say_flood(std::size_t sensors) {
  if (sensors >= client::kMostFound) {
    say_aside("stof: " + std::to_string(client::kMostFound) +
              " sensors are announced, as many as are kept: somebody near floods this network");
  }
}

std::string discover_line(const client::FoundSensor& sensor) {
  std::string line = sensor.serial + " '" + sensor.name + "' at " + sensor.endpoint() + ": " +
                     sensor.board + ", version " + sensor.version + ", health " +
                     health_name(sensor.health) + (sensor.standby ? ", standby" : "");
  if (sensor.rate_millihertz) {
    line += printed(", %.1f Hz, %u of %u subscribers",
                    static_cast<double>(*sensor.rate_millihertz) / 1000, sensor.subscribers,
                    sensor.most_subscribers);
  }
  if (sensor.by_link_alone()) {
    line += "; in another network than this computer (stof address)";
  }
  line += "; by";
  for (const std::string& method : methods_of(sensor)) {
    line += " " + method;
  }
  return line;
}

std::string rival_text(const client::FoundSensor& sensor) {
  return "two sensors answer with serial number " + sensor.serial + ", at " + sensor.address +
         " and " + sensor.rival + ": give each a number of its own (stofd --device)";
}

std::string discover_json(const std::vector<client::FoundSensor>& sensors) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const client::FoundSensor& sensor : sensors) {
    nlohmann::ordered_json entry{
        {"serial", sensor.serial},       {"name", sensor.name},
        {"address", sensor.address},     {"port", sensor.port},
        {"device_id", sensor.device_id}, {"version", sensor.version},
        {"board", sensor.board},         {"health", health_name(sensor.health)},
        {"found_by", methods_of(sensor)}};
    if (!sensor.rival.empty()) {
      entry["rival"] = sensor.rival;
    }
    if (sensor.rate_millihertz) {
      entry["standby"] = sensor.standby;
      entry["rate_hz"] = static_cast<double>(*sensor.rate_millihertz) / 1000;
      entry["subscribers"] = sensor.subscribers;
      entry["most_subscribers"] = sensor.most_subscribers;
    }
    list.push_back(std::move(entry));
  }
  return json_text(list);
}

void discover(const DiscoverCommand& command) {
  const auto timeout = std::chrono::duration_cast<std::chrono::milliseconds>(
      std::chrono::duration<double>(command.timeout_s));
  auto sensors =
      value_or_fail(client::discover({.timeout = timeout, .addresses = command.addresses}));
  note_rivals(sensors);
  say_flood(sensors.size());
  if (command.json) {
    say(discover_json(sensors));
  } else {
    std::string told;  // the number whose rivals were
    for (const client::FoundSensor& sensor : sensors) {
      say(discover_line(sensor));
      if (!sensor.rival.empty() && told != sensor.serial) {
        say(rival_text(sensor));
        told = sensor.serial;
      }
    }
  }
  if (sensors.empty()) {
    throw Failure(Exit::kFailure,
                  "no sensor answered: check power and cable, or name it: --address HOST");
  }
}

void add_discover(CLI::App& app, DiscoverCommand& command) {
  CLI::App& discover_command =
      *app.add_subcommand("discover", "List the sensors near: serial, name, address, health");
  show_example(discover_command, "stof discover",
               "Ends with 0 (some were found), 1 (none, or the output cannot be written) or 2 (bad "
               "input).");
  discover_command
      .add_option("--timeout", command.timeout_s, "Seconds to wait; a beacon comes once a second")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  discover_command.add_option("--address", command.addresses,
                              "Also ask HOST[:PORT], also beyond the local network");
  discover_command.add_flag("--json", command.json, "A JSON array");
  discover_command.callback([&command] { discover(command); });
}

}  // namespace stof::host
