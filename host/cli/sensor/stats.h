#pragma once

#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "host/cli/receive.h"
#include "host/cli/sensor/stream_figures.h"
#include "host/recording/recording.h"

namespace stof::host {

struct StatsOptions : ReceiveOptions {
  double seconds = 5;
  bool json = false;
};

// Of a file: what could not be read, and whether it is whole.
struct Damage {
  std::uint64_t records = 0;
  std::uint64_t bytes = 0;
  recording::FileState state{};
};

// What a stream came to, of a sensor or of a recording.
struct StreamStats {
  std::string source{};  // the sensor's place, or the file
  std::optional<std::uint32_t> device{};
  StreamFigures figures{};
  client::Statistics counts{};
  unsigned silences = 0;
  unsigned restarts = 0;
  std::optional<Damage> damage{};  // none: it is of a sensor
};

// Of the whole of it. json: of a command that prints JSON, without progress. Throws Failure where
// it is none, or holds no frame.
StreamStats stats_of_file(const std::string& file, bool json);

std::string stats_text(const StreamStats& stats);
nlohmann::ordered_json stats_json(const StreamStats& stats);

// Adds `stof stats`.
void add_stats(CLI::App& app, StatsOptions& options);

}  // namespace stof::host
