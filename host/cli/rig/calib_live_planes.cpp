#include <optional>

#include "host/calibrate/rig/planes/plane_disparities.h"
#include "host/calibrate/rig/target/pair_folder.h"
#include "host/cli/failure.h"
#include "host/cli/live/wall_walk.h"
#include "host/cli/rig/hold_watch.h"
#include "host/cli/rig/live_views.h"
#include "host/cli/stop_signal.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr std::size_t kStillExposures = 3;

class LivePlanes {
 public:
  LivePlanes(const CalibStereoOptions& options, const PlaneOptions& search)
      : options_(options),
        search_(search),
        kept_(options.planes, "wall"),
        lines_(options.json),
        walk_(options.distances, kept_.folder()) {}

  void run() {
    read_kept();
    if (!walk_.next()) {
      return;
    }
    LiveShots shots(options_.live, false);
    lines_.note("subscribing at " + options_.live.sensor + "; walls are kept in " +
                kept_.folder().string());
    while (const std::optional<double> z = walk_.next()) {
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
      walk_.add(value_or_fail(plane_distance(dir)));
    }
  }

  void ask(double z) const {
    lines_.note(printed("put the wall at %.4g m, facing the rig, and press Enter", z));
    wait_for_wall(walk_);
  }

  // Where the wall cannot be matched, it is asked for once more.
  void take(LiveShots& shots, double z) {
    HoldWatch watch(options_.live.most_motion_px, kStillExposures);
    bool old = true;  // from before the wall stood there
    while (std::optional<RawShot> shot = shots.next(walk_.kept_text())) {
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
        lines_.note("left out: " + plane.error().message);
        return;
      }
      kept_.keep(staged);
      walk_.add(z);
      lines_.note(printed("%s: taken at %.4g m, %.0f percent of it matched",
                          staged.filename().c_str(), z, plane->matched * kPercent));
      return;
    }
    throw Failure(Exit::kFailure, shots.why() + ": " + walk_.kept_text());
  }

  const CalibStereoOptions& options_;
  PlaneOptions search_;
  KeptViews kept_;
  LiveLines lines_;
  WallWalk walk_;
};

}  // namespace

void calib_live_planes(const CalibStereoOptions& options, const PlaneOptions& search) {
  stop_on_signals();
  LivePlanes(options, search).run();
}

}  // namespace stof::host
