#pragma once

#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "firmware/wire/messages/event.h"
#include "firmware/wire/messages/health.h"
#include "host/cli/live/link_teller.h"
#include "host/cli/receive.h"

namespace stof::host {

struct HealthOptions : ReceiveOptions {
  double seconds = 0;
  bool json = false;
};

// A sensor's own word on how it is.
struct HealthState {
  std::string source{};  // the sensor's place, or the file
  wire::HealthReport report{};
  // Since it arrived; of a recording up to its end. None: not known.
  std::optional<client::Duration> age{};
};

// The last one of a recording; json as stats_of_file(). Throws Failure where it holds none.
HealthState health_of_file(const std::string& file, bool json);

// A line with the figures and the age, and one for each condition: its name, how bad it is, what it
// means, what to do.
std::string health_text(const HealthState& state);
nlohmann::ordered_json health_json(const HealthState& state);
// Beside it, where health goes on: {"source", "event": {...}} and {"source", "link": {...}}.
nlohmann::ordered_json event_json(const std::string& source, const wire::EventReport& event);
nlohmann::ordered_json change_json(const std::string& source, const LinkTeller::Change& change);

// Adds `stof health`.
void add_health(CLI::App& app, HealthOptions& options);

}  // namespace stof::host
