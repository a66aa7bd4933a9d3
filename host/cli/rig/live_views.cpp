#include "host/cli/rig/live_views.h"

#include <cmath>
#include <system_error>
#include <utility>

#include "dataset/dataset.h"
#include "dataset/files/file.h"
#include "host/calibrate/rig/target/pair_folder.h"
#include "host/cli/failure.h"
#include "host/cli/own_keys.h"
#include "host/cli/stop_signal.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr const char* kStaged = "staged";

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error == std::errc::no_space_on_device) {
    throw Failure(Exit::kFailure, folder.string() +
                                      ": cannot be made a folder: the disk is full: make room, or "
                                      "give another disk");
  }
  if (!std::filesystem::is_directory(folder, error)) {
    throw Failure(Exit::kBadInput, folder.string() +
                                       ": cannot be made a folder: check the path and its "
                                       "permissions");
  }
}

std::filesystem::path write_pair(const std::filesystem::path& to, const RawShot& shot) {
  make_folder(to);
  value_or_end(dataset::write_pgm8(to / "left.pgm", shot.left));
  value_or_end(dataset::write_pgm8(to / "right.pgm", shot.right));
  return to;
}

}  // namespace

KeptViews::KeptViews(std::filesystem::path folder, std::string prefix)
    : folder_(std::move(folder)), prefix_(std::move(prefix)) {
  std::error_code error;
  made_ = !std::filesystem::exists(folder_, error);
  make_folder(folder_);
  std::filesystem::remove_all(folder_ / kStaged, error);
  value_or_fail(pairs_so_far(folder_));
}

KeptViews::~KeptViews() {
  std::error_code error;
  if (made_) {
    std::filesystem::remove(folder_, error);  // an empty one alone
  }
}

std::size_t KeptViews::count() const {
  const dataset::Loaded<std::vector<std::filesystem::path>> pairs = pairs_so_far(folder_);
  return pairs ? pairs->size() : 0;
}

bool KeptViews::empty() const { return count() == 0; }

std::string KeptViews::next_name() const {
  for (int number = 1;; ++number) {
    std::string name = printed("%s_%03d", prefix_.c_str(), number);
    if (!dataset::is_there(folder_ / name)) {
      return name;
    }
  }
}

std::filesystem::path KeptViews::write(const std::string& name, const RawShot& shot) const {
  keep(stage(name, shot));
  return folder_ / name;
}

std::filesystem::path KeptViews::stage(const std::string& name, const RawShot& shot) const {
  const std::filesystem::path staged = folder_ / kStaged / name;
  try {
    return write_pair(staged, shot);
  } catch (const Failure&) {
    drop(staged);
    throw;
  }
}

void KeptViews::keep(const std::filesystem::path& staged) const {
  std::error_code error;
  std::filesystem::rename(staged, folder_ / staged.filename(), error);
  if (error) {
    throw Failure(Exit::kFailure, (folder_ / staged.filename()).string() +
                                      ": cannot be written: " + error.message());
  }
  std::filesystem::remove_all(staged.parent_path(), error);
}

void KeptViews::drop(const std::filesystem::path& staged) {
  std::error_code error;
  std::filesystem::remove_all(staged.parent_path(), error);
}

void write_samples(const std::filesystem::path& folder,
                   const std::vector<dataset::Image<std::uint16_t>>& frames,
                   std::int32_t after_pair_us, const dsp::PmdSensor& sensor) {
  dataset::PmdRecording recording;
  recording.frames = frames;
  recording.calibration.pmd = sensor;
  recording.fixed_pattern.assign(sensor.fixed_pattern.begin(), sensor.fixed_pattern.end());
  recording.calibration.pmd.fixed_pattern = recording.fixed_pattern;
  recording.after_pair_us = after_pair_us;
  value_or_end(dataset::write_pmd(folder / "pmd", recording));
}

LiveShots::LiveShots(const CalibLiveOptions& options, bool pmd)
    : feed_(options, {.pmd = pmd, .every = options.every}),
      end_(std::chrono::steady_clock::now() +
           std::chrono::duration_cast<std::chrono::steady_clock::duration>(
               std::chrono::duration<double>(options.time_limit_s))),
      limit_s_(options.time_limit_s) {}

std::optional<RawShot> LiveShots::next(const std::string& kept) {
  constexpr std::chrono::milliseconds kLook{100};
  while (true) {
    if (asked_to_stop()) {
      why_ = "stopped";
      return std::nullopt;
    }
    if (std::chrono::steady_clock::now() > end_) {
      why_ = printed("the time limit of %.0f s is over", limit_s_);
      return std::nullopt;
    }
    try {
      if (std::optional<RawShot> shot = feed_.next(kLook)) {
        return shot;
      }
    } catch (const Failure& failure) {
      throw Failure(failure.code(), failure.what() + (kept.empty() ? "" : "; " + kept));
    }
  }
}

}  // namespace stof::host
