#include <cmath>
#include <utility>

#include "dataset/files/file.h"
#include "host/calibrate/rig/extrinsics/pmd_board_views.h"
#include "host/calibrate/rig/extrinsics/wall_pairs.h"
#include "host/cli/failure.h"
#include "host/cli/rig/hold_watch.h"
#include "host/cli/rig/live_views.h"
#include "host/cli/stop_signal.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

bool same_size(const dsp::Pinhole& lens, int width, int height) {
  return lens.width == width && lens.height == height;
}

// The pictures of this rig, or Failure.
void check_size(const RawShot& shot, const CalibFolderOptions& options,
                const dsp::Calibration& rig) {
  const dsp::Pinhole& pmd = rig.pmd.lens;
  const int pmd_height = shot.pmd.height / 4;
  const bool pair = same_size(rig.stereo.left, shot.left.width, shot.left.height);
  if (!pair || (shot.pmd.width > 0 && !same_size(pmd, shot.pmd.width, pmd_height))) {
    throw Failure(Exit::kBadInput,
                  options.calibration.string() + ": is of another rig: the sensor's pictures are " +
                      dataset::size_text(shot.left.width, shot.left.height) +
                      (shot.pmd.width > 0 ? " and " + dataset::size_text(shot.pmd.width, pmd_height)
                                          : std::string()) +
                      ": give the calibration of this rig");
  }
}

// What the views that were kept come to, of walls or of a board.
class PlaceViews {
 public:
  PlaceViews(const CalibFolderOptions& options, const dsp::Calibration& rig)
      : options_(options), rig_(rig) {
    if (!options.board.empty()) {
      board_ = value_or_fail(board_named(options.board));
    }
  }

  // The folder's views, whose names are new; what is wrong with them, or empty.
  std::string add(const std::filesystem::path& folder) {
    if (board_) {
      const PmdBoardViews found = value_or_fail(read_board_views(folder, rig_, *board_));
      boards_ += found.views.size();
      return found.refused.empty() ? std::string() : found.refused.front();
    }
    FoundWalls found = walls_of(value_or_fail(read_looks(folder, rig_,
                                                         {.min_disparity = options_.min_disparity,
                                                          .disparities = options_.disparities,
                                                          .threads = options_.threads})));
    for (SeenWall& wall : found.walls) {
      walls_.push_back(std::move(wall));
    }
    return found.refused.empty() ? std::string() : found.refused.front();
  }

  std::size_t count() const { return board_ ? boards_ : walls_.size(); }

  // Empty: nothing is.
  std::string missing() const {
    std::string text;
    for (const std::string& line : board_ ? std::vector<std::string>() : missing_tilts(walls_)) {
      if (!line.starts_with("more")) {
        add_to(text, line, "; ");
      }
    }
    if (count() < options_.live.views) {
      add_to(text, printed("more: %zu of %zu views", count(), options_.live.views), "; ");
    }
    return text;
  }

 private:
  const CalibFolderOptions& options_;
  const dsp::Calibration& rig_;
  std::optional<Board> board_;
  std::vector<SeenWall> walls_;
  std::size_t boards_ = 0;
};

std::string missing_line(const PlaceViews& views) {
  const std::string missing = views.missing();
  return missing.empty() ? "all views are there" : "missing: " + missing;
}

// All of a view that is to be judged, or none. `kept_text` is told where it cannot be written.
std::filesystem::path stage(const KeptViews& kept, const HeldView& held,
                            const dsp::PmdSensor& sensor, const std::string& kept_text) {
  const std::string name = kept.next_name();
  try {
    std::filesystem::path staged = kept.stage(name, held.first);
    write_samples(staged, held.samples, held.first.pmd_after_pair_us, sensor);
    return staged;
  } catch (const Failure& failure) {
    KeptViews::drop(kept.folder() / "staged" / name);
    throw Failure(failure.code(), std::string(failure.what()) + "; " + kept_text);
  }
}

}  // namespace

std::filesystem::path calib_live_walls(const CalibFolderOptions& options,
                                       const dsp::Calibration& rig) {
  stop_on_signals();
  const bool walls = options.board.empty();
  const KeptViews kept(live_folder(options.live, options.out, walls ? ".walls" : ".boards"),
                       walls ? "wall" : "view");
  PlaceViews views(options, rig);
  if (!kept.empty()) {
    views.add(kept.folder());
  }
  const auto kept_text = [&] {
    return views.count() == 0 ? std::string("no view was taken")
                              : printed("views in %s: %zu; run it again to go on",
                                        kept.folder().c_str(), views.count());
  };
  LiveShots shots(options.live, true);
  LiveLines lines(options.json);
  lines.note("subscribing at " + options.live.sensor + "; views are kept in " +
             kept.folder().string());
  lines.note(missing_line(views));
  HoldWatch watch(options.live.most_motion_px, options.live.pmd_frames);
  while (!views.missing().empty()) {
    std::optional<RawShot> shot = shots.next(kept_text());
    if (!shot) {
      throw Failure(Exit::kFailure, shots.why() + ": " + kept_text() + "; " + missing_line(views));
    }
    check_size(*shot, options, rig);
    const std::optional<HeldView> held = watch.add(std::move(*shot));
    if (!held) {
      lines.tell(watch.state(), watch.hint());
      continue;
    }
    const std::filesystem::path staged = stage(kept, *held, rig.pmd, kept_text());
    const std::string wrong = views.add(staged.parent_path());
    if (wrong.empty()) {
      kept.keep(staged);
      lines.note(staged.filename().string() + ": taken; " + missing_line(views));
    } else {
      KeptViews::drop(staged);
      lines.note("left out: " + wrong);
    }
  }
  return kept.folder();
}

std::filesystem::path calib_live_pictures(const CalibFolderOptions& options,
                                          const dsp::Calibration& rig) {
  stop_on_signals();
  const KeptViews kept(live_folder(options.live, options.calibration, ".check"), "picture");
  if (!kept.empty()) {
    throw Failure(Exit::kBadInput, kept.folder().string() +
                                       ": holds pictures already: judge them (stof calib check " +
                                       kept.folder().string() +
                                       "), remove them, or name another folder (--keep)");
  }
  const bool pmd = rig.pmd.lens.width > 0;
  LiveShots shots(options.live, pmd);
  LiveLines(options.json).note("subscribing at " + options.live.sensor);
  for (std::size_t n = 0; n < options.live.views; ++n) {
    const std::optional<RawShot> shot = shots.next({});
    if (!shot) {
      throw Failure(Exit::kFailure, shots.why() + printed(": %zu pictures came", n));
    }
    check_size(*shot, options, rig);
    const std::filesystem::path folder = kept.write(kept.next_name(), *shot);
    if (pmd) {
      write_samples(folder, {shot->pmd}, shot->pmd_after_pair_us, rig.pmd);
    }
  }
  return kept.folder();
}

}  // namespace stof::host
