#include "host/cli/sensor/confirm_sensor.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <sstream>
#include <vector>

#include "host/cli/failure.h"
#include "host/cli/output.h"
#include "host/discovery/discover.h"

namespace stof::host {
namespace {

constexpr std::size_t kMostAsked = 4;  // any host may be made to look like one of its addresses

bool is_ipv6(const std::string& address) { return address.find(':') != std::string::npos; }

// First where it was found, then all others that all programs take, then those of IPv6.
std::vector<std::string> places_of(const client::FoundSensor& sensor) {
  std::vector<std::string> addresses{sensor.address};
  for (const bool later : {false, true}) {
    for (const std::string& address : sensor.heard) {
      if (is_ipv6(address) == later && address != sensor.address) {
        addresses.push_back(address);
      }
    }
  }
  std::erase(addresses, client::kNoAddress);
  addresses.resize(std::min(addresses.size(), kMostAsked));
  return addresses;
}

// It runs on this computer, or is reached as if: no other host has such an address.
bool is_here(const client::FoundSensor& sensor) {
  return std::ranges::any_of(
      sensor.heard, [](const std::string& address) { return address.starts_with("127."); });
}

// The hardware addresses of IPv4 neighbours, as the system knows them (proc(5), /proc/net/arp).
std::string hardware_of(const std::string& address) {
  std::ifstream table("/proc/net/arp");
  std::string line;
  while (std::getline(table, line)) {
    std::istringstream words(line);
    std::string ip, kind, flags, hardware;
    if (words >> ip >> kind >> flags >> hardware && ip == address) {
      return hardware;
    }
  }
  return {};
}

// Two addresses of one network card are one host's.
bool on_one_card(const std::string& address, const std::string& other) {
  const std::string card = hardware_of(address);
  return !card.empty() && card == hardware_of(other);
}

std::string shown(const client::FoundSensor& sensor) {
  return sensor.serial + " ('" + sensor.name + "')";
}

struct Answers {
  std::vector<std::string> own;  // where it says that it is this sensor: HOST:PORT, once a card
  std::string other{};           // where another one answers, and which; empty: there is none
};

Answers ask_places(const client::FoundSensor& sensor,
                   const std::function<bool(const client::FoundSensor&)>& fits) {
  using std::chrono_literals::operator""ms;
  Answers heard;
  std::string first;  // address of heard.own[0]
  for (const std::string& address : places_of(sensor)) {
    // Once it is found, a second address matters where any host could have it.
    if (!heard.own.empty() && (is_ipv6(address) || is_here(sensor))) {
      break;
    }
    client::FoundSensor at = sensor;
    at.address = address;
    const auto answer = client::ask_sensor(at.endpoint(), heard.own.empty() ? 1200ms : 400ms);
    if (!answer) {
      continue;
    }
    if (answer->device_id == sensor.device_id && answer->serial == sensor.serial && fits(*answer)) {
      if (first.empty() || !on_one_card(first, address)) {
        heard.own.push_back(at.endpoint());
      }
      first = first.empty() ? address : first;
    } else if (heard.other.empty()) {
      heard.other = at.endpoint() + ", where sensor " + shown(*answer) + " answers";
    }
  }
  return heard;
}

}  // namespace

std::string confirmed_endpoint(const std::string& called, const client::FoundSensor& sensor,
                               const std::function<bool(const client::FoundSensor&)>& fits) {
  const Answers heard = ask_places(sensor, fits);
  if (heard.own.empty() && !heard.other.empty()) {
    throw Failure(Exit::kBadInput,
                  called + ": what is announced as this sensor leads to " + heard.other +
                      ": somebody near announces what is not so, or it has just been changed: name "
                      "the sensor that is meant by its address");
  }
  if (heard.own.size() > 1) {
    say_aside("stof: " + called + ": " + heard.own[0] + " and " + heard.own[1] +
              " answer as this sensor; the first is asked. Its key alone tells who it is (stof "
              "pair)");
  }
  return heard.own.empty() ? sensor.endpoint() : heard.own.front();
}

std::vector<client::FoundSensor> still_there(
    std::span<const client::FoundSensor> found,
    const std::function<bool(const client::FoundSensor&)>& fits) {
  const auto again = client::discover({.timeout = std::chrono::seconds(1)});
  std::vector<client::FoundSensor> there;
  if (!again) {
    return there;
  }
  const auto is_found = [&](const client::FoundSensor& now) {
    return std::ranges::any_of(found, [&](const client::FoundSensor& before) {
      return before.device_id == now.device_id && before.serial == now.serial &&
             before.port == now.port;
    });
  };
  for (const client::FoundSensor& now : *again) {
    const bool answers =
        now.answers_link || now.methods[static_cast<std::size_t>(client::DiscoveryMethod::kDirect)];
    if (answers && is_found(now) && there.size() < kMostAsked &&
        (now.by_link_alone() || !ask_places(now, fits).own.empty())) {
      there.push_back(now);
    }
  }
  return there;
}

void refuse_two_names(const client::FoundSensor& sensor) {
  if (!sensor.other_name.empty()) {
    throw Failure(Exit::kBadInput,
                  sensor.serial + ": is announced with the names '" + sensor.name + "' and '" +
                      sensor.other_name +
                      "': somebody announces what is not so, or it has just been changed: name it "
                      "by its address, where this computer reaches it, or try again");
  }
}

}  // namespace stof::host
