#include "host/cli/calib_live_pmd.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>

#include "dataset/files/file.h"
#include "host/calibrate/pmd_calibration.h"
#include "host/calibrate/walls/pmd_wall.h"
#include "host/cli/failure.h"
#include "host/cli/live/live_lines.h"
#include "host/cli/live/raw_feed.h"
#include "host/cli/live/wall_walk.h"
#include "host/cli/stop_signal.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr double kMostMovedM = 0.01;
constexpr double kMostSaturated = 0.5;
constexpr double kLightMPerS = 299'792'458;

// What the middle of some frames shows.
struct MiddleSum {
  std::complex<double> phasor;
  std::size_t pixels = 0;
  std::size_t saturated = 0;
};

void add_middle(const dataset::Image<std::uint16_t>& frame, const dsp::PmdSensor& camera,
                MiddleSum& sum) {
  const Middle middle = middle_of(camera.lens);
  for (int v = middle.top; v < middle.bottom; ++v) {
    for (int u = middle.left; u < middle.right; ++u) {
      std::array<double, 4> a{};
      for (int k = 0; k < 4; ++k) {
        a[static_cast<std::size_t>(k)] = frame.view().at(u, v + k * camera.lens.height);
      }
      sum.phasor += std::complex<double>(a[0] - a[2], a[3] - a[1]);
      ++sum.pixels;
      sum.saturated += std::ranges::max(a) >= camera.saturation_lsb ? 1U : 0U;
    }
  }
}

class PmdWalls {
 public:
  PmdWalls(const PmdLiveOptions& options, std::filesystem::path folder, std::filesystem::path start,
           const dsp::PmdSensor& camera, bool aside)
      : options_(options),
        folder_(std::move(folder)),
        start_(std::move(start)),
        camera_(camera),
        lines_(aside),
        walk_(options.distances, folder_) {
    camera_.fixed_pattern = {};
    std::error_code error;
    std::filesystem::create_directories(folder_, error);
  }

  void run() {
    for (const std::filesystem::path& prefix : value_or_fail(list_walls(folder_))) {
      walk_.add(value_or_fail(read_wall(prefix)).z_m);
    }
    if (walk_.distances() < kFewestWalls) {
      throw Failure(Exit::kBadInput,
                    printed("--distances: with the walls of %s these are %zu distances: a "
                            "calibration needs %zu at least",
                            folder_.c_str(), walk_.distances(), kFewestWalls));
    }
    if (!walk_.next()) {
      return;
    }
    RawFeed feed(options_, {.pmd = true, .every = 1});
    lines_.note("subscribing at " + options_.sensor + "; walls are kept in " + folder_.string());
    while (const std::optional<double> z = walk_.next()) {
      ask(*z);
      take(feed, *z);
    }
  }

 private:
  void ask(double z) const {
    lines_.note(
        printed("put the wall at %.4g m from the PMD camera, facing it, and press Enter", z));
    wait_for_wall(walk_);
  }

  RawShot next_shot(RawFeed& feed) const {
    constexpr std::chrono::milliseconds kLook{100};
    while (true) {
      if (asked_to_stop()) {
        throw Failure(Exit::kFailure, "stopped: " + walk_.kept_text());
      }
      std::optional<RawShot> shot;
      try {
        shot = feed.next(kLook);
      } catch (const Failure& failure) {
        throw Failure(failure.code(), std::string(failure.what()) + "; " + walk_.kept_text());
      }
      if (shot) {
        return std::move(*shot);
      }
    }
  }

  // A wall that is no recording is asked for once more.
  void take(RawFeed& feed, double z) {
    WallRecording wall{.name = printed("z%04ld", std::lround(z * kMm)), .z_m = z, .recording = {}};
    next_shot(feed);  // from before the wall stood there
    while (wall.recording.frames.size() < options_.exposures) {
      RawShot shot = next_shot(feed);
      if (shot.pmd.width != camera_.lens.width || shot.pmd.height != 4 * camera_.lens.height) {
        throw Failure(Exit::kBadInput, start_.string() +
                                           ": is of another PMD camera: the sensor's has " +
                                           dataset::size_text(shot.pmd.width, shot.pmd.height / 4) +
                                           " pixels: give the calibration of this rig");
      }
      wall.recording.frames.push_back(std::move(shot.pmd));
    }
    if (const std::string why = problem_of_wall(wall.recording.frames, camera_); !why.empty()) {
      lines_.note("left out: " + why);
      return;
    }
    wall.recording.calibration.pmd = camera_;
    keep(wall);
    walk_.add(z);
    lines_.note(
        printed("%s: taken at %.4g m, %zu exposures", wall.name.c_str(), z, options_.exposures));
  }

  void keep(const WallRecording& wall) const {
    const std::expected<void, dataset::Problem> written = write_wall(folder_ / wall.name, wall);
    if (!written) {
      for (const char* const ending : {".json", "_raw.pgm"}) {
        std::error_code error;
        std::filesystem::remove(dataset::file_of(folder_ / wall.name, ending), error);
      }
      throw Failure(Exit::kFailure, written.error().message + "; " + walk_.kept_text());
    }
  }

  const PmdLiveOptions& options_;
  std::filesystem::path folder_;
  std::filesystem::path start_;
  dsp::PmdSensor camera_;
  LiveLines lines_;
  WallWalk walk_;
};

}  // namespace

std::string problem_of_wall(const std::vector<dataset::Image<std::uint16_t>>& frames,
                            const dsp::PmdSensor& camera) {
  std::array<MiddleSum, 2> halves{};
  for (std::size_t n = 0; n < frames.size(); ++n) {
    add_middle(frames[n], camera, halves[2 * n < frames.size() ? 0 : 1]);
  }
  const double saturated = static_cast<double>(halves[0].saturated + halves[1].saturated) /
                           static_cast<double>(halves[0].pixels + halves[1].pixels);
  if (saturated > kMostSaturated) {
    return printed(
        "%.0f percent of the pixels in the middle are saturated: shorten the "
        "integration, or take this distance out",
        saturated * kPercent);
  }
  const double turn = std::arg(halves[1].phasor * std::conj(halves[0].phasor));
  const double moved =
      std::abs(turn) * kLightMPerS / (4 * std::numbers::pi * camera.frequency.modulation.value);
  if (moved > kMostMovedM) {
    return printed("the wall moved by %.0f mm, %.0f are allowed: hold it still", moved * kMm,
                   kMostMovedM * kMm);
  }
  return {};
}

void record_pmd_walls(const PmdLiveOptions& options, const std::filesystem::path& folder,
                      const std::filesystem::path& start, const dsp::PmdSensor& camera,
                      bool aside) {
  stop_on_signals();
  PmdWalls(options, folder, start, camera, aside).run();
}

}  // namespace stof::host
