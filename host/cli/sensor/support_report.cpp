#include "host/cli/sensor/support_report.h"

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iterator>
#include <map>
#include <utility>

#include <sys/utsname.h>
#include <unistd.h>

#include "dataset/files/file.h"
#include "host/cli/failure.h"
#include "host/cli/help_text.h"
#include "host/cli/json_output.h"
#include "host/cli/output.h"
#include "host/cli/recording/info.h"
#include "host/cli/recording/sensor_documents.h"
#include "host/cli/sensor/find_sensor.h"
#include "host/cli/sensor/sensor_info.h"
#include "host/cli/sensor/tar.h"
#include "host/cli/sensor_text.h"
#include "host/cli/stop_signal.h"
#include "host/cli/view/frame_copy.h"
#include "host/client/control/control_client.h"
#include "host/recording/mcap/reader.h"
#include "host/recording/mcap/storage.h"
#include "host/recording/recording.h"
#include "host/text/printed.h"
#include "posix/named_file.h"

namespace stof::host {
namespace {

using Json = nlohmann::ordered_json;
using Files = std::map<std::string, std::string>;  // bytes by name

std::string pretty(const Json& json) { return json_text(json) + "\n"; }

std::string computer_json(const std::string& version) {
  utsname system{};
  if (::uname(&system) != 0) {
    return pretty({{"stof", version}});
  }
  return pretty({{"stof", version},
                 {"system", system.sysname},
                 {"release", system.release},
                 {"kernel", system.version},
                 {"machine", system.machine}});  // not the computer's name
}

// A folder that is gone with its owner.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "stof_report_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) {
      throw Failure(Exit::kFailure, name + ": cannot be made: make room in the temporary folder");
    }
    folder_ = name;
  }
  ~ScratchFolder() {
    std::error_code none;
    std::filesystem::remove_all(folder_, none);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return folder_; }

 private:
  std::filesystem::path folder_;
};

void add_pictures(const FrameCopy& frame, Files& files) {
  const ScratchFolder scratch;
  frame.write(scratch.path(), {});
  for (const auto& entry : std::filesystem::directory_iterator(scratch.path())) {
    std::ifstream in(entry.path(), std::ios::binary);
    files["frame/" + entry.path().filename().string()] =
        std::string(std::istreambuf_iterator<char>(in), {});
  }
}

// What anybody may read. A sensor that gives one of them not is no reason to give no report.
void add_documents(const SupportReportOptions& options, Files& files) {
  using Document = wire::SettingsDocument;
  const std::pair<Document, const char*> documents_of_settings[] = {
      {Document::kActive, "settings_active.json"},
      {Document::kSaved, "settings_saved.json"},
      {Document::kDefaults, "settings_defaults.json"}};
  auto client =
      client::ControlClient::open(sensor_address(options.sensor), reading_control(options));
  for (const auto& [document, name] : documents_of_settings) {
    auto answer = client ? client->request(wire::SettingsOperation::kGet, document, {})
                         : std::unexpected(client.error());
    files[name] = answer ? std::move(answer->text) : answer.error().message + "\n";
  }
  recording::SensorDocuments documents = read_documents(options, true);
  if (documents.calibration.empty()) {
    files["calibration.txt"] = documents.no_calibration + "\n";
  } else {
    files["calibration.cal"] = std::move(documents.calibration);
  }
}

// It may fall silent in the middle: then the report says so.
void add_info_of_sensor(const SupportReportOptions& options, Files& files) {
  try {
    const SensorInfo info = read_sensor_info(options);
    files["info.txt"] = sensor_info_text(info);
    files["info.json"] = pretty(sensor_info_json(info));
  } catch (const Failure& failure) {
    files["info.txt"] = std::string(failure.what()) + "\n";
  }
}

void add_verdict(const CheckFacts& facts, const std::string& source, Files& files) {
  const std::vector<Check> checks = judge_checks(facts);
  files["check.txt"] = checks_text(checks);
  files["check.json"] = pretty(checks_json(source, checks));
  if (facts.stats.figures.frames() != 0) {
    files["stats.txt"] = stats_text(facts.stats);
    files["stats.json"] = pretty(stats_json(facts.stats));
  }
  if (facts.health) {
    files["health.txt"] = health_text(*facts.health);
    files["health.json"] = pretty(health_json(*facts.health));
  }
}

Files collect_sensor(const SupportReportOptions& options) {
  Files files;
  FrameCopy newest;
  std::string events;
  const CheckFacts facts = check_sensor(
      options,
      [&](const client::Frame& frame) {
        if (!options.no_pictures && (frame.complete() || newest.empty())) {
          newest.keep(frame);
        }
      },
      [&](const wire::EventReport& event) { events += event_line(event) + "\n"; });
  add_verdict(facts, options.sensor, files);
  files["events.txt"] = events.empty() ? "none came\n" : events;
  if (facts.stats.figures.frames() != 0) {
    add_info_of_sensor(options, files);
    add_documents(options, files);
  }
  if (!newest.empty()) {
    try {
      add_pictures(newest, files);
    } catch (const Failure& failure) {  // the temporary folder is full
      files["frame.txt"] = std::string(failure.what()) + "\n";
    }
  }
  return files;
}

// What the sensor ran with when it was recorded; the last one of each name.
void add_attachments(const std::string& file, Files& files) {
  const auto source = value_or_fail(mcap::FileSource::open(file));
  auto reader = mcap::StreamReader::open(source);
  while (reader) {
    const auto item = reader->next();
    if (item && !*item) {
      return;
    }
    const auto* const attachment = item ? std::get_if<mcap::Attachment>(&**item) : nullptr;
    const bool settings =
        attachment != nullptr && attachment->name == recording::kSettingsAttachment;
    if (settings ||
        (attachment != nullptr && attachment->name == recording::kCalibrationAttachment)) {
      files[settings ? "settings_recorded.json" : "calibration.cal"] =
          std::string(reinterpret_cast<const char*>(attachment->data.data()),  // NOLINT: bytes
                      attachment->data.size());
    }
  }
}

void add_frame_and_events(const SupportReportOptions& options, Files& files) {
  auto reader = value_or_fail(recording::FrameReader::open(options.sensor));
  std::optional<recording::RecordedFrame> whole;
  while (std::optional<recording::RecordedFrame> frame = reader.next()) {
    if (!options.no_pictures && (frame->missing_packets == 0 || !whole)) {
      whole = std::move(frame);
    }
  }
  FrameCopy newest;
  if (whole) {
    newest.keep(whole->whole_view());
  }
  std::string events;
  for (const auto& [log_time, event] : reader.sights().events) {
    events += printed("%.3f s  ", static_cast<double>(log_time) / 1e9) + event_line(event) + "\n";
  }
  files["events.txt"] = events.empty() ? "none are in it\n" : events;
  if (!newest.empty()) {
    try {
      add_pictures(newest, files);
    } catch (const Failure& failure) {  // the temporary folder is full
      files["frame.txt"] = std::string(failure.what()) + "\n";
    }
  }
}

Files collect_file(const SupportReportOptions& options) {
  Files files;
  add_verdict(check_file(options), options.sensor, files);
  add_attachments(options.sensor, files);
  add_frame_and_events(options, files);
  const recording::Summary summary = value_or_fail(recording::summarise(options.sensor));
  files["info.txt"] = info_text(options.sensor, summary);
  files["info.json"] = info_json(options.sensor, summary) + "\n";
  return files;
}

// FILE before anything is asked, so that what cannot be written is known at once.
class ReportFile {
 public:
  ReportFile(const std::filesystem::path& file, bool force) : file_(file) {
    auto made = posix::create_named_file(file.string());
    made_ = made.has_value();
    if (!made && made.error() == EEXIST && force) {
      made = posix::open_named_file(file.string(), false);
    }
    if (!made && made.error() == EEXIST) {
      throw Failure(Exit::kBadInput, file.string() + ": is there: give another file, or --force");
    }
    if (!made) {
      throw Failure(Exit::kBadInput, dataset::refuse_to_write(file, made.error()).error().message);
    }
    // Nothing written tells of a device that takes nothing.
    if (::write(made->get(), "", 0) < 0) {
      throw Failure(Exit::kFailure, dataset::refuse_to_write(file, errno).error().message);
    }
  }
  // One that was made for nothing goes again.
  ~ReportFile() {
    if (made_ && !written_) {
      std::error_code none;
      std::filesystem::remove(file_, none);
    }
  }
  ReportFile(const ReportFile&) = delete;
  ReportFile& operator=(const ReportFile&) = delete;

  void write(const std::string& bytes) {
    if (const auto done = dataset::write_whole(file_, bytes); !done) {
      throw Failure(Exit::kFailure, done.error().message);
    }
    written_ = true;
  }

 private:
  std::filesystem::path file_;
  bool made_ = false;
  bool written_ = false;
};

constexpr const char* kAbout =
    "What stof report found. check.txt says first what has to be mended.\n"
    "check, stats, health, info: for people (.txt) and programs (.json). settings_*.json, "
    "calibration.cal: as the sensor gave them. events.txt: what began or ended meanwhile. frame/: "
    "pictures of one frame, what the sensor saw (--no-pictures leaves them out). computer.json: "
    "this computer's system. Of a recording: what it holds of them, settings as it began "
    "(settings_recorded.json), events with the time since 1970 at which they were recorded.\n"
    "There are no keys in it. Addresses of the network are.\n";

void support_report(const SupportReportOptions& options) {
  stop_on_signals();
  const bool recorded = is_recorded(options.sensor);
  ReportFile file(options.file, options.force);
  Files files = recorded ? collect_file(options) : collect_sensor(options);
  const bool heard = files.contains("stats.json");
  files["about.txt"] = kAbout;
  files["computer.json"] = computer_json(options.version);
  Tar tar(std::time(nullptr));
  const std::string folder = "stof-report/";
  Json names = Json::array();
  for (const auto& [name, bytes] : files) {
    tar.add(folder + name, bytes);
    names.push_back(name);
  }
  const std::string bytes = tar.take();
  file.write(bytes);
  if (options.json) {
    say_text(pretty({{"file", options.file.string()},
                     {"source", options.sensor},
                     {"bytes", bytes.size()},
                     {"frames_came", heard},
                     {"files", std::move(names)}}));
  } else {
    say_text(files["check.txt"]);
    say(printed(
        "wrote %s: %zu files, %.1f kB; without keys, with %s", options.file.c_str(), files.size(),
        static_cast<double>(bytes.size()) / 1e3,
        files.contains("frame/depth.png") ? "pictures of what the sensor sees" : "no picture"));
  }
  if (!heard) {
    throw Failure(Exit::kFailure, options.sensor + ": no frame came; " + options.file.string() +
                                      " says what was found");
  }
}

}  // namespace

void add_support_report(CLI::App& app, SupportReportOptions& options, const char* version) {
  options.version = version;
  CLI::App& command = *app.add_subcommand(
      "report", "One file for whoever helps you: checks, health, figures, settings, a frame");
  show_example(command, "stof report 192.168.1.20 report.tar",
               "A tar file of texts and JSON, calibration and pictures of one frame. No key is in "
               "it.\n"
               "Ends with 0 (written, whatever it says), 1 (no frame came: it is written and says "
               "why; or it cannot be written) or 2 (bad input).");
  add_reading_flags(command, options, options.json);
  command.add_option("FILE", options.file, "The report, by custom NAME.tar")->required();
  command.add_option("--seconds", options.seconds, "How long it listens, from the first frame")
      ->check(CLI::Range(0.5, 3600.0))
      ->capture_default_str();
  command.add_flag("--no-pictures", options.no_pictures, "Nothing of what the sensor sees");
  command.add_flag("--force", options.force, "Replace FILE where it is there");
  command.callback([&options, &command] {
    judge_reading_flags(command, options.sensor);
    support_report(options);
  });
}

}  // namespace stof::host
