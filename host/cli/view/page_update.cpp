#include "host/cli/view/page_update.h"

#include <algorithm>
#include <exception>
#include <system_error>
#include <utility>
#include <vector>

#include "host/cli/failure.h"
#include "host/cli/own_keys.h"
#include "host/cli/release_upload.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr double kPutPatienceS = 15;  // without an answer
constexpr double kReadPatienceS = 0.5;
constexpr double kVerdictWaitS = 240;
constexpr std::size_t kMostReleases = 50;
constexpr const char* kUpdateUnderWay = "an update is under way";

std::vector<viewer::ReleaseFile> releases_in(const std::filesystem::path& folder) {
  std::vector<viewer::ReleaseFile> files;
  std::error_code error;
  for (auto at = std::filesystem::directory_iterator(folder, error);
       !error && at != std::filesystem::directory_iterator() && files.size() < kMostReleases;
       at.increment(error)) {
    std::error_code none;
    if (at->path().extension() == ".update" && at->is_regular_file(none)) {
      files.push_back(
          {.name = at->path().filename().string(), .bytes = std::filesystem::file_size(*at, none)});
    }
  }
  std::ranges::sort(files, {}, &viewer::ReleaseFile::name);
  return files;
}

std::string release_text(std::uint32_t fingerprint) {
  return fingerprint == 0 ? std::string() : printed("%08x", fingerprint);
}

const char* name_of_state(wire::UploadState state) {
  switch (state) {
    case wire::UploadState::kSettled:
      return "settled";
    case wire::UploadState::kOnTrial:
      return "trial";
    case wire::UploadState::kRestarting:
      return "restarting";
    case wire::UploadState::kLeft:
      return "left";
  }
  return "";
}

}  // namespace

PageUpdate::PageUpdate(ConfigOptions config, std::filesystem::path folder, Task::Tell tell)
    : config_(std::move(config)),
      folder_(std::move(folder)),
      task_({.folder = folder_.string()}, std::move(tell)) {}

void PageUpdate::read(const ShownSensor& sensor) {
  std::vector<viewer::ReleaseFile> files;
  if (!folder_.empty()) {
    files = releases_in(folder_);
  }
  const bool busy = task_.under_way();
  viewer::UpdateState found;
  try {
    if (busy) {
      // What follows the update tells it.
    } else if (sensor.address.empty()) {
      found.problem = "no frame has come: nobody knows where the sensor is";
    } else {
      const auto way = open_upload_way("update", sensor.address, config_, kReadPatienceS);
      const auto state = way->uploads.state_of(wire::UploadKind::kUpdate);
      if (!state) {
        throw Failure(Exit::kFailure, state.error().message);
      }
      if (state->result != wire::SettingsResult::kOk) {
        refuse_upload(*state, way->place);
      }
      found.running = release_text(state->fingerprint);
      found.other = release_text(state->former);
      found.state = name_of_state(state->state);
    }
  } catch (const std::exception& problem) {
    found.problem = problem.what();
  }
  task_.change([&](viewer::UpdateState& state) {
    state.files = std::move(files);
    if (!busy) {
      state.running = std::move(found.running);
      state.other = std::move(found.other);
      state.state = std::move(found.state);
      state.problem = std::move(found.problem);
    }
  });
}

PageUpdate::Task::Done PageUpdate::may_begin(const ShownSensor& sensor) const {
  if (folder_.empty()) {
    return std::unexpected("no folder of releases was named: stof view SENSOR --update-from DIR");
  }
  if (sensor.address.empty()) {
    return std::unexpected("no frame has come: nobody knows where the sensor is");
  }
  return {};
}

PageUpdate::Task::Done PageUpdate::put(const viewer::Page& page, const ShownSensor& sensor,
                                       const std::string& file) {
  if (Task::Done may = may_begin(sensor); !may) {
    return may;
  }
  const std::vector<viewer::ReleaseFile> files = releases_in(folder_);
  if (std::ranges::find(files, file, &viewer::ReleaseFile::name) == files.end()) {
    return std::unexpected("no such release is in " + folder_.string() +
                           ": choose one of the list");
  }
  return task_.start(
      page, kUpdateUnderWay,
      [&file](viewer::UpdateState& state) {
        state.step = "sending";
        state.file = file;
        state.sent = state.total = 0;
        state.text.clear();
        state.problem.clear();
      },
      [this, address = sensor.address, path = folder_ / file] { return run(address, path); });
}

PageUpdate::Task::Done PageUpdate::revert(const viewer::Page& page, const ShownSensor& sensor) {
  if (Task::Done may = may_begin(sensor); !may) {
    return may;
  }
  return task_.start(
      page, kUpdateUnderWay,
      [](viewer::UpdateState& state) {
        state.step = "restarting";
        state.file.clear();
        state.sent = state.total = 0;
        state.text = "the sensor is being asked";
        state.problem.clear();
      },
      [this, address = sensor.address] { return run(address, {}); });
}

PageUpdate::Task::End PageUpdate::run(const std::string& sensor,
                                      const std::filesystem::path& file) {
  need_crypto();
  const std::string bytes = file.empty() ? std::string() : read_release(file);
  const auto way = open_upload_way("update", sensor, config_, kPutPatienceS);
  const ReleaseEnd end =
      put_release(*way, bytes, kVerdictWaitS,
                  {.sent =
                       [this](std::size_t now, std::size_t all) {
                         task_.change([&](viewer::UpdateState& state) {
                           state.sent = now;
                           state.total = all;
                         });
                       },
                   .told =
                       [this](ReleaseStep told, const std::string& line) {
                         task_.change([&](viewer::UpdateState& state) {
                           state.step = told == ReleaseStep::kOnTrial ? "trial" : "restarting";
                           state.text = line;
                         });
                       },
                   .goes_on = [this] { return task_.goes_on(); }});
  switch (end.state) {
    case ReleaseState::kConfirmed:
      return {.step = "confirmed", .text = end.line};
    case ReleaseState::kReverted:
      return {.step = "left", .text = end.line};
    default:
      return {.step = "failed", .text = end.line};
  }
}

}  // namespace stof::host
