#include "host/cli/sensor/find_sensor.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "host/cli/discover.h"
#include "host/cli/failure.h"
#include "host/cli/sensor/confirm_sensor.h"
#include "host/client/control/link_transport.h"
#include "host/client/sensor_socket.h"
#include "host/discovery/discover.h"

namespace stof::host {
namespace {

bool is_address(const std::string& called) {
  return called.empty() || called == "localhost" ||
         called.find_first_of(".:[") != std::string::npos;
}

using Fits = std::function<bool(const client::FoundSensor&)>;

struct Way {
  std::string endpoint;                    // HOST[:PORT]
  std::optional<client::LinkTarget> link;  // it answers by broadcast alone
  std::optional<std::uint32_t> device{};   // its number; none: a host
};

void refuse_folder(const std::string& called) {
  std::error_code error;
  if (std::filesystem::is_directory(called, error)) {
    throw Failure(Exit::kBadInput, called + ": is a folder: give a sensor, or a recording");
  }
}

// What is there and is neither a file nor a folder.
void refuse_special(const std::string& called) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(called, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_directory(status)) {
    throw Failure(Exit::kBadInput,
                  called + ": is a pipe, a socket or a device: give a sensor, or a recording");
  }
  if (std::filesystem::is_symlink(std::filesystem::symlink_status(called, error))) {
    throw Failure(Exit::kBadInput,
                  called + ": is a link to what is not there: give a sensor, or a recording");
  }
}

void refuse_file(const std::string& called) {
  if (is_recorded(called)) {
    refuse_folder(called);
    throw Failure(Exit::kBadInput, called + ": is a recording: this takes a sensor that runs");
  }
  // "." and "..": no host is called so.
  if (!called.empty() && called.find_first_not_of('.') == std::string::npos) {
    refuse_folder(called);
  }
}

void refuse_rivals(const client::FoundSensor& sensor) {
  if (!sensor.rival.empty()) {
    throw Failure(Exit::kBadInput,
                  rival_text(sensor) + "; until then name each by its address, or switch one off");
  }
}

// The one of several that is there, if it is one alone: which was heard first says nothing.
client::FoundSensor one_of(const std::string& called, std::span<const client::FoundSensor> found,
                           const Fits& fits) {
  std::vector<client::FoundSensor> there = still_there(found, fits);
  if (there.size() == 1) {
    return std::move(there.front());
  }
  const client::FoundSensor& first = there.empty() ? found[0] : there[0];
  const client::FoundSensor& second = there.empty() ? found[1] : there[1];
  if (first.serial == second.serial) {
    throw Failure(
        Exit::kBadInput,
        called + ": two sensors near say that they have " +
            (first.serial == called ? "this serial number" : "serial number " + first.serial) +
            ", at " + first.endpoint() + " and " + second.endpoint() +
            ": switch one off, or name the one that is meant by its address, where this "
            "computer reaches it");
  }
  throw Failure(Exit::kBadInput, called + ": " +
                                     std::to_string(there.empty() ? found.size() : there.size()) +
                                     " sensors have that name: name one by its serial number, " +
                                     first.serial + " or " + second.serial);
}

Way way_to(const std::string& called, const client::FoundSensor& sensor, const Fits& fits) {
  refuse_rivals(sensor);
  Way way{.endpoint = sensor.endpoint(), .link = {}, .device = sensor.device_id};
  if (!sensor.by_link_alone()) {
    way.endpoint = confirmed_endpoint(called, sensor, fits);
  } else {
    refuse_two_names(sensor);
    way.link = client::LinkTarget{.device_id = sensor.device_id,
                                  .session_id = sensor.session_id,
                                  .port = sensor.port,
                                  .called = sensor.serial};
  }
  return way;
}

Way look_for(const std::string& called) {
  const auto device = serial_device(called);
  const Fits fits = [&](const client::FoundSensor& sensor) {
    return sensor.serial == called || (!device && sensor.name == called);
  };
  const auto sensors = client::discover({.timeout = std::chrono::seconds(3), .wanted = fits});
  if (!sensors) {
    throw Failure(Exit::kFailure, sensors.error().message);
  }
  say_flood(sensors->size());
  std::vector<client::FoundSensor> found;
  std::ranges::copy_if(*sensors, std::back_inserter(found), fits);
  std::erase_if(found, [](const client::FoundSensor& one) {
    return serial_device(one.serial) != one.device_id;
  });
  // A serial number is one sensor's; a name may be another one's number.
  if (std::ranges::find(found, called, &client::FoundSensor::serial) != found.end()) {
    std::erase_if(found, [&](const client::FoundSensor& one) { return one.serial != called; });
  }
  if (found.size() > 1) {
    found = {one_of(called, found, fits)};
  }
  // The system takes a number for an address: 1 for 0.0.0.1.
  const bool is_number = called.find_first_not_of("0123456789") == std::string::npos;
  if (found.empty() && is_number) {
    throw Failure(Exit::kBadInput,
                  called +
                      ": no sensor near has that serial number, as it is written on it, or name: "
                      "stof discover lists the sensors");
  }
  if (found.empty() && !client::resolve_sensor(called)) {
    refuse_folder(called);
    refuse_special(called);
    throw Failure(Exit::kBadInput,
                  called +
                      ": does not exist: no file, no sensor near and no host has that name: "
                      "stof discover lists the sensors");
  }
  return found.empty() ? Way{.endpoint = called, .link = {}} : way_to(called, found.front(), fits);
}

// Looked for once.
const Way& known_way(const std::string& called) {
  static std::map<std::string, Way> known;  // of this one command
  const auto found = known.find(called);
  return found != known.end() ? found->second
                              : known.emplace(called, look_for(called)).first->second;
}

}  // namespace

std::optional<std::uint32_t> serial_device(const std::string& called) {
  constexpr std::size_t kDigits = 8;
  std::uint32_t device = 0;
  const char* const end = called.data() + called.size();
  const bool lower = std::ranges::none_of(called, [](char c) { return c >= 'A' && c <= 'Z'; });
  return lower && called.size() == kDigits &&
                 std::from_chars(called.data(), end, device, 16).ptr == end
             ? std::optional(device)
             : std::nullopt;
}

bool is_recorded(const std::string& sensor) {
  std::error_code error;
  return sensor.find('/') != std::string::npos || sensor.ends_with(".mcap") ||
         (!sensor.empty() && std::filesystem::is_regular_file(sensor, error));
}

std::string sensor_address(const std::string& called) {
  refuse_file(called);
  if (is_address(called)) {
    return called;
  }
  const Way& way = known_way(called);
  if (way.link) {
    throw Failure(Exit::kFailure,
                  called + ": is at " + way.endpoint +
                      " and heard by broadcast alone, because it and this computer have no address "
                      "of one network: stof address " +
                      called + " ADDRESS/BITS gives it one");
  }
  return way.endpoint;
}

std::optional<std::uint32_t> found_device(const std::string& called) {
  refuse_file(called);
  return is_address(called) ? std::nullopt : known_way(called).device;
}

bool is_sensor_name(const std::string& called) {
  return !serial_device(called) && found_device(called);
}

std::unique_ptr<client::ControlTransport> open_sensor(const std::string& called) {
  refuse_file(called);
  if (is_address(called)) {
    return value_or_fail(client::open_udp_transport(called));
  }
  const Way& way = known_way(called);
  return way.link ? value_or_fail(client::open_link_transport(*way.link))
                  : value_or_fail(client::open_udp_transport(way.endpoint));
}

}  // namespace stof::host
