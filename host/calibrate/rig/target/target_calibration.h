#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/calibrate/rig/target/coverage.h"
#include "host/calibrate/rig/target/pair_fit.h"

// From pictures of a board to a pair: which views count, what is fitted, what judges it.
namespace stof::host {

struct TargetOptions {
  Board board;
  // One of so many views that both eyes saw is held out and judges, drawn by lot from those without
  // which the others reach as much of the pictures; 0: none, every view is fitted to and nobody
  // judges.
  int hold_out = 5;
  double most_blur_px = 1.5;  // FoundBoard::blur_px; views that are more blurred do not count
};

struct RefusedView {
  std::string name;
  std::string why;
};

// The views as corners, and what did not become one.
struct TargetViews {
  int width = 0;
  int height = 0;
  std::vector<PairView> views;
  std::vector<RefusedView> refused;
  bool stopped = false;  // before all of them were read
  // How often find_views() found the board, blurred or not; and whether that is because the eye's
  // pictures show it mirrored, where it never did.
  std::size_t left_seen = 0;
  std::size_t right_seen = 0;
  bool left_mirrored = false;
  bool right_mirrored = false;
};

// Of views that were held out.
struct TargetJudgement {
  std::size_t views = 0;
  double reprojection_px = 0;  // rms of a coordinate, the board's pose fitted to the view
  double row_px = 0;           // rms of how far rectified rows of a corner are apart
  double largest_row_px = 0;
  double scale_error =
      0;  // triangulated squares against the board's: mean share they are too large
};

struct TargetCalibration {
  PairFit fit;
  bool tangential = false;  // the views asked for p1 and p2
  bool k3 = false;          // and for k3
  std::vector<PairView> fitted;
  std::vector<ViewPose> poses;  // of `fitted`
  std::vector<PairView> held_out;
  std::vector<ViewResiduals> held_residuals;  // of `held_out`
  std::vector<RefusedView> refused;
  std::vector<std::string> missing;  // views that are: the file is not to be trusted
  std::optional<TargetJudgement> judgement;
  std::vector<std::string> notes;  // other lines for whoever reads what was found
};

// Reads a folder of pairs (pair_folder.h) and finds the board in each. One line where nothing can
// be read, or pairs differ in size. stop: asked before each of them; true: no more are read.
dataset::Loaded<TargetViews> find_views(const std::filesystem::path& folder,
                                        const TargetOptions& options,
                                        const std::function<bool()>& stop = {});

// One line where an eye sees the board in none of the views, or no view counts: what to do. Empty:
// neither.
std::string unseen(const TargetViews& views, const Board& board);

// One line where no pair follows from the views at all. Views that are missing are in `missing`.
// stop: asked at each step of each fit; true: no more is fitted, and "stopped" is the line.
dataset::Loaded<TargetCalibration> calibrate_target(TargetViews views, const TargetOptions& options,
                                                    const std::function<bool()>& stop = {});

// Why the pair cannot be of the rig that `start` is of, or empty: its pictures have another size,
// or the baseline is another one by more than 5 percent, which is what the size of the board's
// squares comes to. Empty too where `start` has no pair.
std::string other_rig(const dsp::Calibration& start, const dsp::RawPair& rig);

// Of one rig, yet the baseline is another one by more than 0.5 percent, which nothing but the size
// of the squares makes: a line that says so, or empty.
std::string other_scale(const dsp::Calibration& start, const dsp::RawPair& rig);

// How far apart the rows of both eyes' rectified corners are, px.
std::vector<double> row_errors(const PairView& view, const dsp::RawPair& rig);

// The calibration of the rig with this pair. The place of a PMD camera that `start` has is kept
// against the left camera's own axes, which the rectified ones have moved against.
dsp::Calibration with_pair(const dsp::Calibration& start, const dsp::RawPair& rig);

}  // namespace stof::host
