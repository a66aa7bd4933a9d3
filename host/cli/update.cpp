#include "host/cli/update.h"

#include <filesystem>

#include "host/cli/failure.h"
#include "host/cli/json_output.h"
#include "host/cli/output.h"
#include "host/cli/progress_line.h"
#include "host/cli/release_upload.h"
#include "host/cli/upload_way.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

struct UpdateWords {
  std::string sensor;
  std::filesystem::path file;
};

UpdateWords read_update_words(const UpdateOptions& options) {
  UpdateWords words;
  std::vector<std::string> given = options.words;
  if (options.serial.empty() && !given.empty()) {
    words.sensor = given.front();
    given.erase(given.begin());
  }
  if (!options.revert && !given.empty()) {
    words.file = given.front();
    given.erase(given.begin());
  }
  if (!given.empty() || words.sensor.empty() == options.serial.empty() ||
      words.file.empty() != options.revert) {
    throw Failure(Exit::kBadInput,
                  "update: takes SENSOR FILE, or --revert SENSOR; with --serial DEVICE no SENSOR: "
                  "try --help");
  }
  return words;
}

nlohmann::ordered_json end_json(const UploadWay& way, const ReleaseEnd& end) {
  nlohmann::ordered_json json = way.json();
  json["release"] = printed("%08x", end.release);
  json["former"] = printed("%08x", end.former);
  json["state"] = name_of(end.state);
  return json;
}

}  // namespace

void update(const UpdateOptions& options) {
  need_crypto();
  const UpdateWords words = read_update_words(options);
  const std::string bytes = options.revert ? std::string() : read_release(words.file);
  const auto way = open_upload_way("update", words.sensor, options, options.patience_s);
  ProgressLine line(options.json);
  const ReleaseEnd end =
      put_release(*way, bytes, options.no_wait ? 0 : options.wait_s,
                  {.sent = [&line](std::size_t now, std::size_t all) { line.show(now, all); },
                   .told =
                       [&](ReleaseStep /*step*/, const std::string& text) {
                         line.end();
                         if (!options.json) {
                           say(text);
                         }
                       }});
  if (options.json) {
    say_json(end_json(*way, end));
  }
  if (end.state == ReleaseState::kReverted || end.state == ReleaseState::kUnknown) {
    throw Failure(Exit::kFailure, end.line);
  }
  if (!options.json && end.state == ReleaseState::kConfirmed) {
    say(end.line);
  }
}

void add_update(CLI::App& app, UpdateOptions& options) {
  CLI::App& command = *app.add_subcommand(
      "update",
      "Put another release on a sensor, signed by its maker, or go back to the former one");
  command.footer(
      "Example: stof update 192.168.1.20 build/images/rpi4.update\n"
      "It goes to the slot that does not run, is tried once, and is confirmed when for 30 s the "
      "sensor published what it published before; else the former one runs again. Takes a key of "
      "role admin (stof pair), or the cable, besides the maker's signature.\n"
      "Ends with 0 (confirmed; with --no-wait: on trial), 1 (no right to, not now, the former one "
      "runs again, or no answer: run it again, it goes on where it stopped) or 2 (bad input, or no "
      "file for this sensor: nothing changed).");
  command.add_option("WORDS", options.words,
                     "SENSOR (serial number, name or HOST[:PORT]) FILE; no FILE with --revert, no "
                     "SENSOR with --serial");
  command.add_flag("--revert", options.revert, "Try the release that is in the other slot");
  command.add_flag("--no-wait", options.no_wait, "End when the sensor restarts");
  add_json_flag(command, options.json);
  add_control_flags(command, options);
  command.add_option("--wait", options.wait_s, "Seconds to wait for what comes of the trial")
      ->check(CLI::Range(1.0, 3600.0))
      ->capture_default_str();
  command.add_option("--patience", options.patience_s, "Seconds to go on without an answer")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  command.callback([&options] { update(options); });
}

}  // namespace stof::host
