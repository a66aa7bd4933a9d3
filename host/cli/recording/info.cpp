#include "host/cli/recording/info.h"

#include <array>
#include <chrono>
#include <ctime>

#include <nlohmann/json.hpp>

#include "host/cli/failure.h"
#include "host/cli/help_text.h"
#include "host/cli/json_output.h"
#include "host/cli/output.h"
#include "host/cli/recording/damage_text.h"
#include "host/cli/recording/file_state.h"
#include "host/cli/recording/reading_progress.h"
#include "host/cli/sensor/find_sensor.h"
#include "host/cli/sensor/sensor_info.h"
#include "host/cli/sensor_text.h"
#include "host/client/printable.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr double kNanosecond = 1e-9;

double seconds_of(const mcap::Statistics& all) {
  return all.end_time < all.start_time
             ? 0
             : static_cast<double>(all.end_time - all.start_time) * kNanosecond;
}

// UTC, "2026-11-26T14:00:00Z"; empty: not a time.
std::string time_text(std::uint64_t nanoseconds) {
  const auto seconds = static_cast<std::time_t>(nanoseconds / 1'000'000'000);
  std::tm parts{};
  std::array<char, 64> text{};
  if (gmtime_r(&seconds, &parts) == nullptr ||
      std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts) == 0) {
    return "";
  }
  return text.data();
}

std::uint64_t count_of(const recording::Summary& summary, std::uint16_t channel) {
  const auto& counts = summary.index.statistics.messages_by_channel;
  const auto found = counts.find(channel);
  return found == counts.end() ? 0 : found->second;
}

std::string schema_of(const recording::Summary& summary, const mcap::Channel& channel) {
  const auto found = summary.index.schemas.find(channel.schema_id);
  return found == summary.index.schemas.end() ? "" : found->second.name;
}

}  // namespace

std::string info_text(const std::string& file, const recording::Summary& summary) {
  const mcap::Statistics& all = summary.index.statistics;
  std::string text =
      client::printable(file) + ": " + file_state_text(summary.state, summary.damaged) + "\n";
  text += all.message_count == 0
              ? std::string("  no messages")
              : printed("  %.1f s from %s", seconds_of(all), time_text(all.start_time).c_str());
  text +=
      printed(", %.1f MB, %llu messages in %zu chunks\n", static_cast<double>(summary.bytes) / 1e6,
              static_cast<unsigned long long>(all.message_count), summary.index.chunks.size());
  text += printed("  %llu frames, %llu of them incomplete, %llu missing in %zu gaps, %u sessions\n",
                  static_cast<unsigned long long>(summary.frames),
                  static_cast<unsigned long long>(summary.incomplete_frames),
                  static_cast<unsigned long long>(summary.frames_missing), summary.gaps.size(),
                  summary.sessions);
  if (summary.damaged != 0) {
    text += printed("  %llu records are damaged, %llu bytes are left out\n",
                    static_cast<unsigned long long>(summary.damaged),
                    static_cast<unsigned long long>(summary.damaged_bytes));
  }
  for (const auto& [key, value] : summary.sensor) {
    text += "  " + client::printable(key) + ": " + client::printable(value) + "\n";
  }
  if (summary.calibration) {
    text += "  " + calibration_line(*summary.calibration) + "\n";
  }
  if (summary.lenses_contradict) {
    text += "  " + lenses_contradict_text() + "\n";
  }
  for (const auto& [id, channel] : summary.index.channels) {
    text += printed("  %8llu  ", static_cast<unsigned long long>(count_of(summary, id))) +
            client::printable(channel.topic) + "  " +
            client::printable(schema_of(summary, channel)) + "\n";
  }
  for (const mcap::AttachmentIndex& one : summary.index.attachments) {
    text += printed("  attachment %s, %llu bytes\n", client::printable(one.name).c_str(),
                    static_cast<unsigned long long>(one.data_size));
  }
  constexpr std::size_t kMostLines = 10;
  for (std::size_t k = 0; k < summary.gaps.size() && k < kMostLines; ++k) {
    const recording::Gap& gap = summary.gaps[k];
    text += printed(
        "  gap: %u frames after number %u, at %.3f s\n", gap.frames, gap.after,
        (static_cast<double>(gap.log_time) - static_cast<double>(all.start_time)) * kNanosecond);
  }
  if (summary.gaps.size() > kMostLines) {
    text += printed("  and %zu gaps more: --json has them\n", summary.gaps.size() - kMostLines);
  }
  return text;
}

std::string info_json(const std::string& file, const recording::Summary& summary) {
  using Json = nlohmann::ordered_json;
  const mcap::Statistics& all = summary.index.statistics;
  Json json{{"file", file},
            {"indexed", summary.state.indexed},
            {"state", file_state_text(summary.state, summary.damaged)},
            {"bytes", summary.bytes},
            {"whole_bytes", summary.whole_bytes},
            {"damaged", summary.damaged},
            {"damaged_bytes", summary.damaged_bytes},
            {"start_ns", all.start_time},
            {"end_ns", all.end_time},
            {"duration_s", seconds_of(all)},
            {"messages", all.message_count},
            {"chunks", summary.index.chunks.size()},
            {"frames", summary.frames},
            {"incomplete_frames", summary.incomplete_frames},
            {"frames_missing", summary.frames_missing},
            {"sessions", summary.sessions},
            {"sensor", summary.sensor}};
  Json& channels = json["channels"] = Json::array();
  for (const auto& [id, channel] : summary.index.channels) {
    channels.push_back({{"topic", channel.topic},
                        {"schema", schema_of(summary, channel)},
                        {"messages", count_of(summary, id)}});
  }
  Json& attachments = json["attachments"] = Json::array();
  for (const mcap::AttachmentIndex& one : summary.index.attachments) {
    attachments.push_back({{"name", one.name}, {"bytes", one.data_size}});
  }
  Json& gaps = json["gaps"] = Json::array();
  for (const recording::Gap& gap : summary.gaps) {
    gaps.push_back({{"after", gap.after}, {"frames", gap.frames}, {"log_time_ns", gap.log_time}});
  }
  json["calibration"] =
      summary.calibration ? calibration_json(*summary.calibration) : Json(nullptr);
  json["lenses_contradict"] = summary.lenses_contradict;
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

void info(const InfoOptions& options) {
  const std::string& file = options.sensor;
  if (!is_recorded(file)) {
    const SensorInfo sensor = read_sensor_info(options);
    if (options.json) {
      say_json(sensor_info_json(sensor));
    } else {
      say_text(sensor_info_text(sensor));
    }
    return;
  }
  const recording::Summary summary = [&] {
    ReadingProgress progress(file, options.json);
    return value_or_fail(recording::summarise(file, progress.callback()));
  }();
  say_text(options.json ? info_json(file, summary) + "\n" : info_text(file, summary));
  if (summary.damaged != 0) {
    throw Failure(Exit::kFailure, file + ": " +
                                      damage_text(summary.damaged, summary.damaged_bytes) +
                                      ": stof recover FILE OUT writes what is sound");
  }
}

void add_info(CLI::App& app, InfoOptions& options) {
  CLI::App& command =
      *app.add_subcommand("info", "What a sensor is and sends, or what a recording holds");
  show_example(command, "stof info 192.168.1.20\nExample: stof info hall.mcap",
               "Ends with 0 (also for a cut recording: it says so), 1 (no frame came, records of "
               "the recording are damaged, or the output cannot be written) or 2 (bad input, no "
               "recording).");
  add_reading_flags(command, options, options.json);
  command.callback([&options, &command] {
    judge_reading_flags(command, options.sensor);
    info(options);
  });
}

}  // namespace stof::host
