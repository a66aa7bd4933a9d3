#include "host/cli/view/page_calibration.h"

#include <algorithm>
#include <array>
#include <ctime>
#include <exception>
#include <optional>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "dataset/files/file.h"
#include "host/cli/calib_install.h"
#include "host/cli/failure.h"
#include "host/cli/own_keys.h"
#include "host/cli/receive.h"
#include "host/cli/recording/sensor_documents.h"
#include "host/cli/view/line_program.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr int kPictureWidth = 320;
constexpr double kInstallPatienceS = 15;  // without an answer
constexpr const char* kFile = "rig.cal";
constexpr const char* kBefore = "before.cal";  // what the sensor has: its PMD camera is kept
constexpr const char* kViews = "views";
constexpr const char* kNowhere = "no frame has come: nobody knows where the sensor is";
constexpr const char* kUnderWay = "a calibration is under way: the page that began it may end it";
// Steps.
constexpr const char* kCalibrated = "calibrated";
constexpr const char* kInstalled = "installed";

std::string folder_prefix(std::uint32_t device) { return printed("calibration_%08x_", device); }

std::uint64_t views_in(const std::filesystem::path& folder) {
  std::uint64_t count = 0;
  std::error_code error;
  for (auto at = std::filesystem::directory_iterator(folder / kViews, error);
       !error && at != std::filesystem::directory_iterator(); at.increment(error)) {
    std::error_code none;
    count += std::filesystem::is_regular_file(at->path() / "left.pgm", none) ? 1U : 0U;
  }
  return count;
}

// The newest calibration of this sensor, where it has views and no file yet.
std::optional<std::filesystem::path> unfinished(const std::filesystem::path& in,
                                                std::uint32_t device) {
  std::optional<std::filesystem::path> newest;
  std::error_code error;
  for (auto at = std::filesystem::directory_iterator(in, error);
       !error && at != std::filesystem::directory_iterator(); at.increment(error)) {
    if (at->path().filename().string().starts_with(folder_prefix(device)) &&
        (!newest || at->path().filename() > newest->filename())) {
      newest = at->path();
    }
  }
  if (!newest || std::filesystem::exists(*newest / kFile, error) || views_in(*newest) == 0) {
    return std::nullopt;
  }
  return newest;
}

std::string stamp_of_now() {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  std::array<char, 32> text{};
  const std::size_t size = std::strftime(text.data(), text.size(), "%Y%m%d_%H%M%S", &local);
  return {text.data(), size};
}

}  // namespace

struct PageCalibration::Run {
  viewer::Page page;
  ShownSensor sensor;
  std::string board;
  std::filesystem::path folder;
};

PageCalibration::PageCalibration(CalibrationOptions options, Task::Tell tell)
    : options_(std::move(options)),
      task_({.problem = options_.absence.empty() ? "" : "calibration: " + options_.absence},
            std::move(tell)) {}

void PageCalibration::read(const ShownSensor& sensor) {
  const auto folder = unfinished(options_.folder, sensor.device);
  const std::uint64_t kept = folder ? views_in(*folder) : 0;
  const bool busy = task_.under_way();
  task_.change([&](viewer::CalibrationState& state) {
    if (busy) {
      return;
    }
    state.kept = kept;
    if (!owner_.connected()) {
      state.by = {};
    }
  });
}

PageCalibration::Done PageCalibration::begin(const viewer::Page& page, const ShownSensor& sensor,
                                             const viewer::BeginCalibration& wish) {
  if (!options_.absence.empty()) {
    return std::unexpected("calibration: " + options_.absence);
  }
  if (sensor.address.empty()) {
    return std::unexpected(kNowhere);
  }
  std::filesystem::path folder = options_.folder / (folder_prefix(sensor.device) + stamp_of_now());
  if (wish.goes_on) {
    if (const auto before = unfinished(options_.folder, sensor.device)) {
      folder = *before;
    }
  }
  const Run what{.page = page, .sensor = sensor, .board = wish.board, .folder = folder};
  const Done begun = task_.start(
      page, kUnderWay,
      [&](viewer::CalibrationState& state) {
        state = {.step = "begin",
                 .by = state.by,
                 .text = "the sensor is being asked",
                 .folder = folder.string()};
      },
      [this, what] { return run(what); });
  if (begun) {
    owner_ = page;
  }
  return begun;
}

PageCalibration::Done PageCalibration::end(const viewer::Page& page) {
  return task_.end_by(page, "no calibration is under way");
}

bool PageCalibration::goes_on(const Run& what) const {
  return task_.goes_on() && what.page.connected();
}

std::vector<std::string> PageCalibration::words(const Run& what) const {
  std::vector<std::string> words{options_.program,
                                 "calib",
                                 "stereo",
                                 "--live",
                                 what.sensor.address,
                                 "--json",
                                 "--picture-width",
                                 std::to_string(kPictureWidth),
                                 "--board",
                                 what.board,
                                 "--out",
                                 (what.folder / kFile).string(),
                                 "--keep",
                                 (what.folder / kViews).string()};
  std::error_code error;
  if (std::filesystem::exists(what.folder / kBefore, error)) {
    words.insert(words.end(), {"--start", (what.folder / kBefore).string()});
  }
  const ConfigOptions& config = options_.config;
  if (config.device) {
    words.insert(words.end(), {"--device", std::to_string(*config.device)});
  }
  // A sensor that is paired gives its pictures to a key alone.
  const OwnRole own = own_role(what.sensor, config);
  if (own.role != "anybody" && own.role != "none") {
    words.insert(words.end(), {"--signed", "--keys", config.keys});
    if (!config.key.empty()) {
      words.insert(words.end(), {"--key", config.key});
    }
  }
  return words;
}

PageCalibration::Task::End PageCalibration::run(const Run& what) {
  Task::End end;
  try {
    end = calibrate(what);
  } catch (const std::exception& problem) {
    end = {.step = "failed", .text = problem.what()};
  }
  if (end.step != kCalibrated && !goes_on(what)) {
    end.step = "ended";
    if (task_.goes_on()) {
      end.text = "the page that began the calibration was closed: its views are kept";
    }
  }
  const std::uint64_t kept = end.step == kCalibrated ? 0 : views_in(what.folder);
  task_.change([&](viewer::CalibrationState& state) {
    state.look.clear();
    state.kept = kept;
  });
  return end;
}

// Throws Failure.
PageCalibration::Task::End PageCalibration::calibrate(const Run& what) {
  std::error_code error;
  std::filesystem::create_directories(what.folder, error);
  if (!std::filesystem::is_directory(what.folder, error)) {
    throw Failure(Exit::kFailure,
                  what.folder.string() + ": cannot be made a folder: see --record-to");
  }
  ReceiveOptions asked;
  asked.sensor = what.sensor.address;
  asked.keys = options_.config.keys;
  asked.device = options_.config.device;
  asked.key = options_.config.key;
  const recording::SensorDocuments documents = read_documents(asked, true);
  if (!documents.calibration.empty()) {
    value_or_fail(dataset::write_whole(what.folder / kBefore, documents.calibration));
  }
  auto program = LineProgram::start(words(what), [&] { return goes_on(what); });
  if (!program) {
    throw Failure(Exit::kFailure, program.error());
  }
  while (const std::optional<std::string> line = program->next_line()) {
    take(*line);
  }
  if (const int code = program->wait(); code != 0) {
    std::string text = program->complaint();
    if (text.starts_with("stof: ")) {
      text.erase(0, 6);
    }
    return {.step = "failed",
            .text = text.empty() ? printed("it ended with %d and said nothing", code) : text};
  }
  return {.step = kCalibrated, .text = (what.folder / kFile).string() + " is written"};
}

void PageCalibration::take(const std::string& line) {
  const auto json = nlohmann::json::parse(line, nullptr, false);
  const auto text = [&](const char* name) {
    const auto at = json.find(name);
    return at != json.end() && at->is_string() ? at->get<std::string>() : std::string();
  };
  if (!json.is_object() || text("state").empty()) {
    return;
  }
  task_.change([&](viewer::CalibrationState& state) {
    state.step = text("state");
    state.text = text("text");
    if (state.step == "looking") {
      state.look = line;
    } else if (json.contains("result")) {
      state.result = json["result"].dump();
    }
  });
}

PageCalibration::Done PageCalibration::install(const viewer::Page& page,
                                               const ShownSensor& sensor) {
  if (sensor.address.empty()) {
    return std::unexpected(kNowhere);
  }
  const viewer::CalibrationState state = task_.state();
  if (!task_.under_way()) {
    if (state.step != kCalibrated && state.step != kInstalled) {
      return std::unexpected("no calibration was made here: begin one");
    }
    if (owner_.connected() && owner_.number != page.number) {
      return std::unexpected("another page, of " + owner_.place +
                             ", made this calibration: only that page installs it");
    }
  }
  const Done begun = task_.start(
      page, kUnderWay,
      [](viewer::CalibrationState& told) {
        told.step = "installing";
        told.text = "the sensor is being sent the file";
        told.wrong = false;
      },
      [this, sensor, file = std::filesystem::path(state.folder) / kFile] {
        return put(sensor, file);
      });
  if (begun) {
    owner_ = page;
  }
  return begun;
}

PageCalibration::Task::End PageCalibration::put(const ShownSensor& sensor,
                                                const std::filesystem::path& file) {
  try {
    need_crypto();
    const std::string bytes = read_calibration_bytes(file);
    const auto way =
        open_upload_way("calib install", sensor.address, options_.config, kInstallPatienceS);
    const Installed done = put_calibration(*way, bytes, {});
    return {.step = kInstalled,
            .text = printed("%s: calibration %08x is in force and kept; it was %08x",
                            way->who().c_str(), done.fingerprint, done.former)};
  } catch (const std::exception& problem) {
    task_.change([](viewer::CalibrationState& state) { state.wrong = true; });
    return {.step = kCalibrated, .text = problem.what()};
  }
}

}  // namespace stof::host
