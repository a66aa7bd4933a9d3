#include "host/cli/calib_install.h"

#include <filesystem>
#include <span>
#include <system_error>

#include "dataset/files/file.h"
#include "firmware/wire/calibration/calibration_file.h"
#include "host/calibrate/calibration_store.h"
#include "host/cli/failure.h"
#include "host/cli/json_output.h"
#include "host/cli/output.h"
#include "host/cli/progress_line.h"
#include "host/cli/upload_way.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 26;

struct InstallWords {
  std::filesystem::path file;
  std::string sensor;
};

bool is_file(const std::filesystem::path& path) {
  std::error_code none;
  return std::filesystem::is_regular_file(path, none);
}

// What is wrong with words that are too few or too many.
std::string missing_text(const CalibInstallOptions& options) {
  const std::size_t count = options.words.size();
  if (options.factory && options.serial.empty()) {
    return count == 0 ? "SENSOR is missing behind --factory"
                      : "--factory takes SENSOR alone, and no FILE";
  }
  if (options.factory) {
    return "--factory with --serial takes neither FILE nor SENSOR";
  }
  if (!options.serial.empty()) {
    return count == 0 ? "FILE is missing: with --serial it is the only word"
                      : "with --serial DEVICE it takes FILE alone, and no SENSOR";
  }
  if (count == 0) {
    return "takes FILE SENSOR, or --factory SENSOR";
  }
  if (count == 1) {
    return is_file(options.words[0])
               ? "SENSOR is missing behind " + options.words[0]
               : "FILE is missing before " + options.words[0] + ", or --factory: takes FILE SENSOR";
  }
  return "takes FILE SENSOR, and nothing behind them";
}

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
    throw Failure(Exit::kBadInput, "calib install: " + missing_text(options));
  }
  if (!options.factory && options.serial.empty() && !is_file(words.file) && is_file(words.sensor)) {
    throw Failure(Exit::kBadInput, "calib install: " + words.file.string() + " is no file, but " +
                                       words.sensor +
                                       " is one: FILE comes before SENSOR: stof calib install " +
                                       words.sensor + " " + words.file.string());
  }
  return words;
}

}  // namespace

std::string read_calibration_bytes(const std::filesystem::path& file) {
  std::string bytes = value_or_fail(dataset::read_whole(file, kMostBytes));
  static_cast<void>(value_or_fail(read_calibration(file)));
  return bytes;
}

Installed put_calibration(UploadWay& way, const std::string& bytes,
                          const std::function<void(std::size_t, std::size_t)>& sent) {
  auto answer = bytes.empty() ? way.uploads.revert(wire::UploadKind::kCalibration)
                              : way.uploads.upload(wire::UploadKind::kCalibration,
                                                   std::as_bytes(std::span(bytes)), sent);
  if (!answer) {
    throw Failure(Exit::kFailure, answer.error().message);
  }
  if (answer->result != wire::SettingsResult::kOk) {
    refuse_upload(*answer, way.place);
  }
  const std::uint32_t meant = wire::calibration_fingerprint(std::as_bytes(std::span(bytes)));
  if (!bytes.empty() && answer->fingerprint != meant) {
    throw Failure(
        Exit::kFailure,
        way.place +
            printed(": says that calibration %08x is in force, and was sent %08x",
                    answer->fingerprint, meant) +
            ": something else answers in the sensor's place, or it cannot use it (stof view)");
  }
  way.remember();
  return {.fingerprint = answer->fingerprint, .former = answer->former};
}

void calib_install(const CalibInstallOptions& options) {
  need_crypto();
  const InstallWords words = read_words(options);
  const std::string bytes = options.factory ? std::string() : read_calibration_bytes(words.file);
  const auto way = open_upload_way("calib install", words.sensor, options, options.patience_s);
  ProgressLine line(options.json);
  const Installed done = put_calibration(
      *way, bytes, [&line](std::size_t now, std::size_t all) { line.show(now, all); });
  line.end();
  if (options.json) {
    nlohmann::ordered_json json = way->json();
    json["calibration"] = printed("%08x", done.fingerprint);
    json["former"] = printed("%08x", done.former);
    json["factory"] = options.factory;
    say_json(json);
  } else {
    say(printed("%s: calibration %08x is in force%s; it was %08x", way->who().c_str(),
                done.fingerprint, options.factory ? ", the factory's" : " and kept", done.former));
  }
}

void add_calib_install(CLI::App& calib, CalibInstallOptions& options) {
  CLI::App& command = *calib.add_subcommand(
      "install", "Put a calibration file on a sensor, or go back to the factory's");
  command.footer(
      "Example: stof calib install rig.cal 192.168.1.20\n"
      "It is in force with the next frame and at each start; stof calib install --factory "
      "192.168.1.20 goes back. Takes a key of role admin (stof pair), or the cable.\n"
      "Ends with 0 (in force and kept), 1 (no right to, or it cannot be kept: nothing changed; or "
      "no answer: run it again) or 2 (bad input, or a file that is not of this rig: nothing "
      "changed).");
  command.add_option(
      "WORDS", options.words,
      "FILE SENSOR, in this order (serial number, name or HOST[:PORT]); no FILE with "
      "--factory, no SENSOR with --serial");
  command.add_flag("--factory", options.factory,
                   "Go back to the calibration that the sensor had before the first install");
  add_json_flag(command, options.json);
  add_control_flags(command, options);
  command.add_option("--patience", options.patience_s, "Seconds to go on without an answer")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  command.callback([&options] { calib_install(options); });
}

}  // namespace stof::host
