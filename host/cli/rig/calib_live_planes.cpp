#include <optional>
#include <set>

#include "host/calibrate/rig/planes/plane_disparities.h"
#include "host/calibrate/rig/target/pair_folder.h"
#include "host/cli/failure.h"
#include "host/cli/live/enter_wait.h"
#include "host/cli/rig/hold_watch.h"
#include "host/cli/rig/live_views.h"
#include "host/cli/stop_signal.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr std::size_t kStillExposures = 3;
constexpr double kSameM = 1e-6;

class LivePlanes {
 public:
  LivePlanes(const CalibStereoOptions& options, const PlaneOptions& search)
      : options_(options), search_(search), kept_(options.planes, "wall") {}

  void run() {
    read_kept();
    if (!next()) {
      return;
    }
    LiveShots shots(options_.live, false);
    LiveLines::say("subscribing at " + options_.live.sensor + "; walls are kept in " +
                   kept_.folder().string());
    while (const std::optional<double> z = next()) {
      ask(*z);
      take(shots, *z);
    }
  }

 private:
  void read_kept() {
    if (kept_.empty()) {
      return;
    }
    for (const std::filesystem::path& dir : value_or_fail(list_pairs(kept_.folder()))) {
      there_.insert(value_or_fail(plane_distance(dir)));
    }
  }

  // The first distance whose wall is not there; none: all are.
  std::optional<double> next() const {
    for (const double z : options_.distances) {
      const auto from = there_.lower_bound(z - kSameM);
      if (from == there_.end() || *from > z + kSameM) {
        return z;
      }
    }
    return std::nullopt;
  }

  std::string kept_text() const {
    return there_.empty() ? std::string("no wall was taken")
                          : printed("walls in %s: %zu; run it again to go on",
                                    kept_.folder().c_str(), there_.size());
  }

  void ask(double z) const {
    LiveLines::say(printed("put the wall at %.4g m, facing the rig, and press Enter", z));
    switch (wait_for_enter(asked_to_stop)) {
      case Answer::kEnter:
        return;
      case Answer::kStopped:
        throw Failure(Exit::kFailure, "stopped: " + kept_text());
      case Answer::kNobody:
        throw Failure(Exit::kFailure, "stdin ended, nobody presses Enter: " + kept_text());
    }
  }

  // Where the wall cannot be matched, it is asked for once more.
  void take(LiveShots& shots, double z) {
    HoldWatch watch(options_.live.most_motion_px, kStillExposures);
    bool old = true;  // from before the wall stood there
    while (std::optional<RawShot> shot = shots.next(kept_text())) {
      if (old) {
        old = false;
        continue;
      }
      const std::optional<HeldView> held = watch.add(std::move(*shot));
      if (!held) {
        lines_.tell(watch.state(), watch.hint());
        continue;
      }
      const std::filesystem::path staged = kept_.stage(kept_.next_name(), held->first);
      value_or_fail(write_plane_distance(staged, z));
      const dataset::Loaded<Plane> plane = read_plane(staged, search_);
      if (!plane) {
        KeptViews::drop(staged);
        LiveLines::say("left out: " + plane.error().message);
        return;
      }
      kept_.keep(staged);
      there_.insert(z);
      LiveLines::say(printed("%s: taken at %.4g m, %.0f percent of it matched",
                             staged.filename().c_str(), z, plane->matched * kPercent));
      return;
    }
    throw Failure(Exit::kFailure, shots.why() + ": " + kept_text());
  }

  const CalibStereoOptions& options_;
  PlaneOptions search_;
  KeptViews kept_;
  LiveLines lines_;
  std::set<double> there_;  // distances of walls in the folder
};

}  // namespace

void calib_live_planes(const CalibStereoOptions& options, const PlaneOptions& search) {
  stop_on_signals();
  LivePlanes(options, search).run();
}

}  // namespace stof::host
