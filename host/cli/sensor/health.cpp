#include "host/cli/sensor/health.h"

#include <array>
#include <chrono>

#include "firmware/wire/messages/conditions.h"
#include "host/cli/failure.h"
#include "host/cli/help_text.h"
#include "host/cli/json_output.h"
#include "host/cli/live/reception.h"
#include "host/cli/output.h"
#include "host/cli/recording/reading_progress.h"
#include "host/cli/sensor/find_sensor.h"
#include "host/cli/sensor_text.h"
#include "host/client/value_names.h"
#include "host/recording/recording.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

// As docs/WIRE.md calls them.
constexpr std::array kSeverityNames{"info", "minor", "major", "critical"};
constexpr std::array kReactionNames{"none", "watch", "slow", "stop"};

struct ActiveCondition {
  std::string name{};
  const wire::ConditionInfo* info = nullptr;  // none: of a newer sensor
};

std::string condition_name(std::uint8_t condition) {
  const wire::ConditionInfo* const info = wire::info_of(static_cast<wire::Condition>(condition));
  return info != nullptr ? info->name : "condition_" + std::to_string(condition);
}

std::vector<ActiveCondition> active_of(const wire::HealthReport& report) {
  constexpr std::uint8_t kBits = 32;
  std::vector<ActiveCondition> active;
  for (std::uint8_t k = 0; k < kBits; ++k) {
    if (((report.active >> k) & 1U) != 0) {
      active.push_back(
          {.name = condition_name(k), .info = wire::info_of(static_cast<wire::Condition>(k))});
    }
  }
  return active;
}

const char* severity_name(wire::Severity severity) {
  return client::name_in(kSeverityNames, static_cast<std::size_t>(severity));
}
const char* reaction_name(wire::Reaction reaction) {
  return client::name_in(kReactionNames, static_cast<std::size_t>(reaction));
}

void print(const HealthOptions& options, const HealthState& state) {
  if (!options.json) {
    say_text(health_text(state));
  } else if (options.seconds > 0) {
    say_json_line(health_json(state));
  } else {
    say_json(health_json(state));
  }
}

void tell(const HealthOptions& options, const std::string& source, const wire::EventReport& event) {
  if (options.json) {
    say_json_line(event_json(source, event));
  } else {
    say(event_line(event));
  }
}

void receive_health(const HealthOptions& options) {
  std::optional<std::uint64_t> told;  // uptime of the health that was printed last
  client::Time began = client::Time::clock::now();
  Reception reception(options, {.event =
                                    [&](const wire::EventReport& event) {
                                      if (options.seconds > 0) {
                                        tell(options, reception.place(), event);
                                      }
                                    },
                                .line =
                                    [&](const std::string& line) {
                                      if (!options.json) {
                                        say(line);
                                      }
                                    },
                                .change =
                                    [&](const LinkTeller::Change& change) {
                                      if (options.json && options.seconds > 0) {
                                        say_json_line(change_json(reception.place(), change));
                                      }
                                    }});
  reception.run(
      [&] {
        const client::Receiver& receiver = reception.receiver();
        const std::optional<wire::HealthReport>& health = receiver.health();
        if (health && told != health->uptime_ms) {
          told = health->uptime_ms;
          print(
              options,
              {.source = reception.place(), .report = *health, .age = receiver.link().health_age});
        }
        const client::Time now = client::Time::clock::now();
        const std::chrono::duration<double> most(options.seconds > 0 ? options.seconds
                                                                     : options.timeout_s);
        return (options.seconds <= 0 && told) || now - began >= most;
      },
      Reception::Awaited::kAnything);
  if (!told || reception.silent()) {
    reception.fail();
  }
}

void health(const HealthOptions& options) {
  if (is_recorded(options.sensor)) {
    print(options, health_of_file(options.sensor, options.json));
  } else {
    receive_health(options);
  }
}

}  // namespace

HealthState health_of_file(const std::string& file, bool json) {
  auto reader = value_or_fail(recording::FrameReader::open(file));
  std::uint64_t end = 0;
  ReadingProgress progress(file, json);
  while (const std::optional<recording::RecordedFrame> frame = reader.next()) {
    end = std::max(end, frame->log_time);
    progress.show(reader.position(), reader.size());
  }
  const auto& all = reader.sights().health;
  if (all.empty()) {
    throw Failure(Exit::kFailure, file + ": holds no health: stof info says what it holds");
  }
  const auto& [time, report] = all.back();
  return {.source = file,
          .report = report,
          .age = std::chrono::duration_cast<client::Duration>(
              std::chrono::nanoseconds(end > time ? end - time : 0))};
}

std::string health_text(const HealthState& state) {
  std::string text =
      state.source + "\n  " + health_line(state.report) + "\n  " + age_text(state.age) + " old\n";
  for (const ActiveCondition& one : active_of(state.report)) {
    text += "  " + one.name + ": ";
    text += one.info == nullptr
                ? std::string("of a newer sensor: update stof")
                : std::string(one.info->text) + " (" + severity_name(one.info->severity) + "); " +
                      reaction_text(one.info->reaction);
    text += "\n";
  }
  return text;
}

nlohmann::ordered_json health_json(const HealthState& state) {
  using Json = nlohmann::ordered_json;
  const wire::HealthReport& report = state.report;
  constexpr double kMilli = 1e-3;
  // 0: no frame in the last second, or none that was measured.
  const auto of_a_frame = [](std::uint32_t us) {
    return us == 0 ? Json(nullptr) : Json(us * kMilli);
  };
  Json conditions = Json::array();
  for (const ActiveCondition& one : active_of(report)) {
    Json entry{{"name", one.name}};
    if (one.info != nullptr) {
      entry["severity"] = severity_name(one.info->severity);
      entry["reaction"] = reaction_name(one.info->reaction);
      entry["text"] = one.info->text;
      entry["advice"] = reaction_text(one.info->reaction);
    }
    conditions.push_back(std::move(entry));
  }
  return {{"source", state.source},
          {"age_s",
           state.age ? Json(std::chrono::duration<double>(*state.age).count()) : Json(nullptr)},
          {"severity", severity_name(report.severity)},
          {"reaction", reaction_name(report.reaction)},
          {"advice", reaction_text(report.reaction)},
          {"uptime_s", static_cast<double>(report.uptime_ms) * kMilli},
          {"rate_hz", report.rate_millihertz * kMilli},
          {"latency_ms", of_a_frame(report.latency_us)},
          {"longest_latency_ms", of_a_frame(report.longest_latency_us)},
          {"subscribers", report.subscribers},
          {"settings_revision", report.settings_revision},
          {"conditions", std::move(conditions)},
          {"counters",
           {{"edges", report.counters.edges},
            {"frames_published", report.counters.frames_published},
            {"mispaired", report.counters.mispaired},
            {"timeouts", report.counters.timeouts},
            {"deadline_misses", report.counters.deadline_misses},
            {"link_drops", report.counters.link_drops},
            {"packets_sent", report.packets_sent}}}};
}

nlohmann::ordered_json event_json(const std::string& source, const wire::EventReport& event) {
  return {{"source", source},
          {"event",
           {{"condition", condition_name(event.condition)},
            {"active", event.active != 0},
            {"severity", severity_name(event.severity)},
            {"reaction", reaction_name(event.reaction)},
            {"at_ns", event.at_ns},
            {"count", event.count},
            {"value", event.value},
            {"text", event_line(event)}}}};
}

nlohmann::ordered_json change_json(const std::string& source, const LinkTeller::Change& change) {
  return {{"source", source}, {"link", {{"state", change.state}, {"text", change.text}}}};
}

void add_health(CLI::App& app, HealthOptions& options) {
  CLI::App& command = *app.add_subcommand(
      "health", "How a sensor is by its own word: conditions, what they mean, what to do");
  show_example(command, "stof health 192.168.1.20",
               "Ends with 0 (told, whatever it says: --json has reaction), 1 (no health came, the "
               "sensor fell silent, or the output cannot be written) or 2 (bad input).");
  add_reading_flags(command, options, options.json);
  command
      .add_option("--seconds", options.seconds,
                  "Go on for so long: each new health, events, and silence at once; 0: the first "
                  "alone. --json: one object a line, health, {event} or {link}")
      ->check(CLI::Range(0.0, 1e7))
      ->capture_default_str();
  command.callback([&options, &command] {
    judge_reading_flags(command, options.sensor);
    health(options);
  });
}

}  // namespace stof::host
