#include "host/cli/calib_install.h"

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <utility>

#include <unistd.h>

#include "dataset/files/file.h"
#include "host/calibrate/calibration_store.h"
#include "host/cli/failure.h"
#include "host/cli/own_keys.h"
#include "host/client/control/upload_client.h"
#include "host/client/control/user_keys.h"

namespace stof::host {
namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 26;

struct InstallWords {
  std::filesystem::path file;
  std::string sensor;
};

InstallWords read_words(const CalibInstallOptions& options) {
  InstallWords words;
  std::vector<std::string> given = options.words;
  if (options.serial.empty() && !given.empty()) {
    words.sensor = given.back();
    given.pop_back();
  }
  if (!options.factory && !given.empty()) {
    words.file = given.front();
    given.erase(given.begin());
  }
  const bool whole = given.empty() && words.sensor.empty() != options.serial.empty() &&
                     words.file.empty() == options.factory;
  if (!whole) {
    throw Failure(Exit::kBadInput,
                  "calib install: takes FILE SENSOR, or --factory SENSOR; with --serial DEVICE no "
                  "SENSOR: try --help");
  }
  return words;
}

// What no sensor takes is told before anything is sent.
std::string read_file(const std::filesystem::path& file) {
  std::string bytes = value_or_fail(dataset::read_whole(file, kMostBytes));
  static_cast<void>(value_or_fail(read_calibration(file)));
  return bytes;
}

// A line that is overwritten, on a terminal alone.
class ProgressLine {
 public:
  void show(std::size_t bytes, std::size_t total) {
    if (shown_) {
      std::fprintf(stderr, "\r%zu of %zu bytes (%zu %%)", bytes, total,
                   total == 0 ? 100 : bytes * 100 / total);
      std::fflush(stderr);
      open_ = true;
    }
  }
  void end() {
    if (std::exchange(open_, false)) {
      std::fputc('\n', stderr);
    }
  }

 private:
  bool shown_ = ::isatty(STDERR_FILENO) == 1;
  bool open_ = false;
};

void refuse(const client::UploadResult& answer, const std::string& place) {
  using Result = wire::SettingsResult;
  std::string why = answer.text;
  if (answer.result == Result::kUnknownKey) {
    why = "has none of your keys any more: pair again (stof pair)";
  } else if (why.empty()) {
    why = "does not know this request: update the sensor";
  }
  throw Failure(answer.result == Result::kInvalid ? Exit::kBadInput : Exit::kFailure,
                place + ": " + why);
}

}  // namespace

void calib_install(const CalibInstallOptions& options) {
  need_crypto();
  const InstallWords words = read_words(options);
  const std::string bytes = options.factory ? std::string() : read_file(words.file);
  const std::string file = keys_file(options.keys);
  const wire::KeyTable keys = value_or_fail(client::read_user_keys(file));
  client::ControlOptions control = timing(options.timeout_s);
  control.keys = keys;
  control.device_id = options.device;
  if (!words.sensor.empty() || !options.key.empty()) {
    const client::Meant meant = meant_or_fail(
        file, keys, words.sensor, {.device = options.device, .key_id = key_id_of(options.key)});
    control.keys = meant.keys;
    control.device_id = meant.device;
  }
  if (!options.serial.empty()) {
    control.unsigned_answers = client::Unsigned::kAlways;
  }
  auto transport = open_way("calib install", words.sensor, options.serial, options.baud);
  const std::string place = transport->place();
  client::ControlClient sensor(std::move(transport), control);
  client::UploadClient uploads(sensor, std::chrono::duration_cast<client::Duration>(
                                           std::chrono::duration<double>(options.patience_s)));
  ProgressLine line;
  auto answer =
      options.factory
          ? uploads.revert(wire::UploadKind::kCalibration)
          : uploads.upload(wire::UploadKind::kCalibration, std::as_bytes(std::span(bytes)),
                           [&line](std::size_t now, std::size_t all) { line.show(now, all); });
  line.end();
  if (!answer) {
    throw Failure(Exit::kFailure, answer.error().message);
  }
  if (answer->result != wire::SettingsResult::kOk) {
    refuse(*answer, place);
  }
  if (sensor.proven() && !words.sensor.empty()) {
    remember_place(file, {.named = words.sensor, .address = place}, sensor.proven()->key_id);
  }
  const std::string who =
      sensor.proven() ? "sensor " + std::to_string(sensor.proven()->device) : place;
  std::printf("%s: calibration %08x is in force%s; it was %08x\n", who.c_str(), answer->fingerprint,
              options.factory ? ", the factory's" : " and kept", answer->former);
}

void add_calib_install(CLI::App& calib, CalibInstallOptions& options) {
  CLI::App& command = *calib.add_subcommand(
      "install", "Put a calibration file on a sensor, or go back to the factory's");
  command.footer(
      "Example: stof calib install rig.cal 192.168.1.20\n"
      "It is in force with the next frame and at each start; stof calib install --factory "
      "192.168.1.20 goes back. Takes a key of role admin (stof pair), or the cable.\n"
      "Ends with 0 (in force and kept), 1 (no right to, or it cannot be kept: nothing changed; or "
      "no "
      "answer: run it again) or 2 (bad input, or a file that is not of this rig: nothing "
      "changed).");
  command.add_option("WORDS", options.words,
                     "FILE SENSOR (HOST[:PORT]); no FILE with --factory, no SENSOR with --serial");
  command.add_flag("--factory", options.factory,
                   "Go back to the calibration that the sensor had before the first install");
  add_control_flags(command, options);
  command.add_option("--patience", options.patience_s, "Seconds to go on without an answer")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  command.callback([&options] { calib_install(options); });
}

}  // namespace stof::host
