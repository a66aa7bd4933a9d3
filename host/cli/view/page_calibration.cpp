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
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr int kPictureWidth = 320;
constexpr double kInstallPatienceS = 15;  // without an answer
constexpr const char* kFile = "rig.cal";
constexpr const char* kBefore = "before.cal";  // what the sensor has: its PMD camera is kept
constexpr const char* kViews = "views";
constexpr const char* kNowhere = "no frame has come: nobody knows where the sensor is";

std::string folder_prefix(std::uint32_t device) { return printed("calibration_%08x_", device); }

std::uint64_t views_in(const std::filesystem::path& folder) {
  std::uint64_t count = 0;
  std::error_code error;
  for (auto at = std::filesystem::directory_iterator(folder / kViews, error);
       !error && at != std::filesystem::directory_iterator(); at.increment(error)) {
    std::error_code none;
    count += std::filesystem::is_regular_file(at->path() / "left.pgm", none) ? 1 : 0;
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

bool same(const PageCalibration::Asker& a, const PageCalibration::Asker& b) {
  return !a.owner_before(b) && !b.owner_before(a);
}

}  // namespace

struct PageCalibration::Run {
  ShownSensor sensor;
  std::string board;
  std::filesystem::path folder;
};

PageCalibration::PageCalibration(CalibrationOptions options, Tell tell)
    : options_(std::move(options)), tell_(std::move(tell)) {
  if (!options_.absence.empty()) {
    state_.problem = "calibration: " + options_.absence;
  }
}

PageCalibration::~PageCalibration() {
  {
    const std::scoped_lock lock(mutex_);
    ends_ = true;
    if (program_ != nullptr) {
      program_->interrupt();
    }
  }
  if (thread_.joinable()) {
    thread_.join();
  }
}

// Told in the order in which it happened.
template <typename Change>
void PageCalibration::change(Change&& how) {
  const std::scoped_lock lock(mutex_);
  std::forward<Change>(how)(state_);
  tell_(state_);
}

void PageCalibration::read(const ShownSensor& sensor) {
  const auto folder = unfinished(options_.folder, sensor.device);
  const std::uint64_t kept = folder ? views_in(*folder) : 0;
  change([&](viewer::CalibrationState& state) {
    if (!under_way_) {
      state.kept = kept;
    }
  });
}

// One line why another page has it; empty: this one does. Guarded by the mutex.
std::string PageCalibration::not_yours(const Asker& asker) const {
  return asker_.expired() || same(asker, asker_)
             ? ""
             : "another page began this calibration: it alone goes on with it";
}

PageCalibration::Done PageCalibration::begin_work(const Asker& asker) {
  {
    const std::scoped_lock lock(mutex_);
    if (under_way_) {
      const std::string other = not_yours(asker);
      return std::unexpected(other.empty() ? "a calibration is under way: end it first" : other);
    }
    under_way_ = true;
    ends_ = false;
    asker_ = asker;
  }
  if (thread_.joinable()) {
    thread_.join();  // it has ended
  }
  return {};
}

PageCalibration::Done PageCalibration::begin(const ShownSensor& sensor,
                                             const viewer::BeginCalibration& wish,
                                             const Asker& asker) {
  if (!options_.absence.empty()) {
    return std::unexpected("calibration: " + options_.absence);
  }
  if (sensor.address.empty()) {
    return std::unexpected(kNowhere);
  }
  if (Done may = begin_work(asker); !may) {
    return may;
  }
  std::filesystem::path folder = options_.folder / (folder_prefix(sensor.device) + stamp_of_now());
  if (wish.goes_on) {
    if (const auto before = unfinished(options_.folder, sensor.device)) {
      folder = *before;
    }
  }
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!std::filesystem::is_directory(folder, error)) {
    const std::scoped_lock lock(mutex_);
    under_way_ = false;
    return std::unexpected(folder.string() + ": cannot be made a folder: see --record-to");
  }
  change([&](viewer::CalibrationState& state) {
    state = {.step = "begin", .text = "the sensor is being asked", .folder = folder.string()};
    file_.clear();
  });
  thread_ = std::thread([this, what = Run{sensor, wish.board, folder}] { run(what); });
  return {};
}

PageCalibration::Done PageCalibration::end(const Asker& asker) {
  const std::scoped_lock lock(mutex_);
  if (!under_way_) {
    return std::unexpected("no calibration is under way");
  }
  if (std::string other = not_yours(asker); !other.empty()) {
    return std::unexpected(std::move(other));
  }
  ends_ = true;
  if (program_ != nullptr) {
    program_->interrupt();
  }
  return {};
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
  words.insert(words.end(), {"--keys", config.keys});
  if (config.device) {
    words.insert(words.end(), {"--device", std::to_string(*config.device)});
  }
  if (!config.key.empty()) {
    words.insert(words.end(), {"--key", config.key});
  }
  // A sensor that is paired gives its pictures to a key alone.
  const OwnRole own = own_role(what.sensor, config);
  if (own.role != "anybody" && own.role != "none") {
    words.emplace_back("--signed");
  }
  return words;
}

void PageCalibration::run(const Run& what) {
  const char* step = "failed";
  std::string text;
  std::optional<LineProgram> program;  // until nobody interrupts it any more
  try {
    ReceiveOptions asked;
    asked.sensor = what.sensor.address;
    asked.keys = options_.config.keys;
    asked.device = options_.config.device;
    asked.key = options_.config.key;
    const SensorDocuments documents = read_documents(asked, true);
    if (!documents.calibration.empty()) {
      value_or_fail(dataset::write_whole(what.folder / kBefore, documents.calibration));
    }
    auto started = LineProgram::start(words(what));
    if (!started) {
      throw Failure(Exit::kFailure, started.error());
    }
    program.emplace(*std::move(started));
    follow(*program);
    const std::scoped_lock lock(mutex_);
    const int code = program->wait();
    program_ = nullptr;
    text = program->complaint();
    if (text.starts_with("stof: ")) {
      text.erase(0, 6);
    }
    if (code == 0) {
      step = "calibrated";
      file_ = what.folder / kFile;
      text = file_.string() + " is written";
    } else if (ends_) {
      step = "ended";
    } else if (text.empty()) {
      text = printed("it ended with %d and said nothing", code);
    }
  } catch (const std::exception& problem) {
    text = problem.what();
  }
  const std::uint64_t kept = views_in(what.folder);
  change([&](viewer::CalibrationState& state) {
    program_ = nullptr;
    state.step = step;
    state.text = text;
    state.look.clear();
    state.kept = file_.empty() ? kept : 0;
    under_way_ = false;
  });
}

// Until it has no more to say.
void PageCalibration::follow(LineProgram& program) {
  {
    const std::scoped_lock lock(mutex_);
    program_ = &program;
    if (ends_) {
      program.interrupt();
    }
  }
  while (const std::optional<std::string> line = program.next_line()) {
    take(*line);
  }
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
  change([&](viewer::CalibrationState& state) {
    state.step = text("state");
    state.text = text("text");
    if (state.step == "looking") {
      state.look = line;
    } else if (json.contains("result")) {
      state.result = json["result"].dump();
    }
  });
}

PageCalibration::Done PageCalibration::install(const ShownSensor& sensor, const Asker& asker) {
  if (sensor.address.empty()) {
    return std::unexpected(kNowhere);
  }
  std::filesystem::path file;
  {
    const std::scoped_lock lock(mutex_);
    if (file_.empty()) {
      return std::unexpected("no calibration was made here: begin one");
    }
    if (std::string other = not_yours(asker); !other.empty()) {
      return std::unexpected(std::move(other));
    }
    file = file_;
  }
  if (Done may = begin_work(asker); !may) {
    return may;
  }
  change([](viewer::CalibrationState& state) {
    state.step = "installing";
    state.text = "the sensor is being sent the file";
  });
  thread_ = std::thread([this, sensor, file] { put(sensor, file); });
  return {};
}

void PageCalibration::put(const ShownSensor& sensor, const std::filesystem::path& file) {
  const char* step = "calibrated";
  std::string text;
  bool wrong = false;
  try {
    need_crypto();
    const std::string bytes = read_calibration_bytes(file);
    const auto way =
        open_upload_way("calib install", sensor.address, options_.config, kInstallPatienceS);
    const Installed done = put_calibration(*way, bytes, {});
    step = "installed";
    text = printed("%s: calibration %08x is in force and kept; it was %08x", way->who().c_str(),
                   done.fingerprint, done.former);
  } catch (const std::exception& problem) {
    wrong = true;
    text = problem.what();
  }
  change([&](viewer::CalibrationState& state) {
    state.step = step;
    state.text = text;
    state.wrong = wrong;
    under_way_ = false;
  });
}

}  // namespace stof::host
