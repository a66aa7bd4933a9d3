#include "host/cli/update.h"

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string_view>
#include <thread>

#include "dataset/files/file.h"
#include "host/cli/failure.h"
#include "host/cli/progress_line.h"
#include "host/cli/upload_way.h"

namespace stof::host {
namespace {

constexpr std::size_t kMostUpdateBytes = std::size_t{1} << 28;
constexpr std::size_t kUpdateHeadBytes = 192;
constexpr std::string_view kUpdateMagic{"STOFUPD\0", 8};
constexpr auto kBetweenAsking = std::chrono::milliseconds(500);
using wire::UploadKind;
using wire::UploadState;

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

// What no sensor takes is told before anything is sent.
std::string read_update_file(const std::filesystem::path& file) {
  std::string bytes = value_or_fail(dataset::read_whole(file, kMostUpdateBytes));
  if (bytes.size() <= kUpdateHeadBytes || !bytes.starts_with(kUpdateMagic)) {
    throw Failure(Exit::kBadInput,
                  file.string() + ": is no update file: name one that scripts/image wrote");
  }
  return bytes;
}

// What comes of the trial: the sensor restarts, perhaps twice, and tells.
void wait_for_verdict(UploadWay& way, std::uint32_t former, std::uint32_t tried, double wait_s) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(wait_s);
  bool told = false;
  bool seen = tried != former;  // the same release again is known by its trial alone
  while (std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(kBetweenAsking);
    const auto state = way.uploads.state_of(UploadKind::kUpdate);
    if (!state || state->result != wire::SettingsResult::kOk) {
      continue;  // it restarts
    }
    if (state->state == UploadState::kOnTrial && state->fingerprint == tried) {
      seen = true;
      if (!told) {
        std::printf("%s: release %08x runs on trial\n", way.who().c_str(), tried);
        std::fflush(stdout);
        told = true;
      }
    } else if (state->state == UploadState::kSettled && seen && state->fingerprint == tried) {
      std::printf("%s: release %08x is confirmed; it was %08x\n", way.who().c_str(), tried, former);
      return;
    } else if (state->fingerprint == former && tried != former &&
               (state->state == UploadState::kSettled || state->state == UploadState::kLeft)) {
      throw Failure(Exit::kFailure, way.who() +
                                        ": went back to the former release: the new one did not "
                                        "publish for 30 s what was published before");
    }
  }
  throw Failure(Exit::kFailure, way.who() +
                                    ": did not tell what came of it: look with stof view, "
                                    "and try again later");
}

}  // namespace

void update(const UpdateOptions& options) {
  need_crypto();
  const UpdateWords words = read_update_words(options);
  const std::string bytes = options.revert ? std::string() : read_update_file(words.file);
  const auto way = open_upload_way("update", words.sensor, options, options.patience_s);
  const auto before = way->uploads.state_of(UploadKind::kUpdate);
  if (!before) {
    throw Failure(Exit::kFailure, before.error().message);
  }
  if (before->result != wire::SettingsResult::kOk) {
    refuse_upload(*before, way->place);
  }
  ProgressLine line;
  const auto answer =
      options.revert
          ? way->uploads.revert(UploadKind::kUpdate)
          : way->uploads.upload(UploadKind::kUpdate, std::as_bytes(std::span(bytes)),
                                [&line](std::size_t now, std::size_t all) { line.show(now, all); });
  line.end();
  if (!answer) {
    throw Failure(Exit::kFailure, answer.error().message);
  }
  if (answer->result != wire::SettingsResult::kOk) {
    refuse_upload(*answer, way->place);
  }
  way->remember();
  std::printf("%s: release %08x is in the other slot; the sensor restarts with it on trial\n",
              way->who().c_str(), answer->former);
  std::fflush(stdout);
  if (!options.no_wait) {
    wait_for_verdict(*way, before->fingerprint, answer->former, options.wait_s);
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
