#include <cmath>
#include <cstdio>

#include "host/calibrate/calibration_store.h"
#include "host/calibrate/rig/extrinsics/pmd_board_views.h"
#include "host/calibrate/rig/report/rig_report.h"
#include "host/cli/calib_files.h"
#include "host/cli/failure.h"
#include "host/cli/json_output.h"
#include "host/cli/output.h"
#include "host/cli/own_keys.h"
#include "host/cli/rig/live_views.h"
#include "host/cli/rig/stereo_json.h"

namespace stof::host {
namespace {

WallPairOptions search_of(const CalibFolderOptions& options) {
  return {.min_disparity = options.min_disparity,
          .disparities = options.disparities,
          .threads = options.threads};
}

// What can be computed with: a pair, complete.
StoredCalibration rig_of(const std::filesystem::path& file) {
  StoredCalibration stored = value_or_fail(read_calibration(file));
  dsp::StereoRig& stereo = stored.calibration.stereo;
  if (*dsp::complete(stereo) != '\0' || stereo.left.width == 0 || stereo.baseline_m == 0) {
    throw Failure(Exit::kBadInput,
                  file.string() + ": holds no stereo pair: calibrate it first (stof calib stereo)");
  }
  return stored;
}

void print(const char* what, const std::vector<std::string>& lines) {
  for (const std::string& line : lines) {
    std::printf("%s: %s\n", what, line.c_str());
  }
}

void refuse_two_sources(const char* command, const CalibFolderOptions& options) {
  if (options.folder.empty() != options.live.on()) {
    throw Failure(Exit::kBadInput,
                  std::string(command) + ": from what: give a folder, or --live SENSOR, not both");
  }
}

using nlohmann::ordered_json;

// The place that was found: X_pair = R X_pmd + T, covariance in rad and m (rotation vector, then
// translation).
ordered_json place_json(const CalibFolderOptions& options, const ExtrinsicFit& fit) {
  const dsp::RigidTransform place = transform_of(fit.pmd_to_stereo);
  ordered_json sigma = ordered_json::array();
  for (Eigen::Index i = 0; i < fit.covariance.rows(); ++i) {
    sigma.push_back(std::sqrt(fit.covariance(i, i)));
  }
  return {{"file", options.out.string()},
          {"calibration", options.calibration.string()},
          {"rotation", place.rotation},
          {"translation_m", place.translation_m},
          {"sigma", sigma},
          {"covariance", matrix_json(fit.covariance)}};
}

ordered_json walls_json(const CalibFolderOptions& options, const ExtrinsicFit& fit,
                        const FoundWalls& found, const std::vector<std::string>& missing) {
  ordered_json json = place_json(options, fit);
  json["misfit"] = fit.misfit;
  json["turned_rad"] = fit.turned_rad;
  json["apart_mm"] = fit.apart_m * kMmPerMetre;
  json["pmd_offset_mm"] = fit.offset_m * kMmPerMetre;
  json["pmd_offset_sigma_mm"] = fit.offset_sigma_m * kMmPerMetre;
  json["walls"] = ordered_json::array();
  for (std::size_t n = 0; n < found.walls.size(); ++n) {
    const SeenWall& wall = found.walls[n];
    json["walls"].push_back({{"name", wall.name},
                             {"off_sigmas", fit.wall_misfit[n]},
                             {"pair_share", wall.stereo.share},
                             {"pmd_share", wall.pmd.share}});
  }
  json["left_out"] = found.refused;
  json["missing"] = missing;
  return json;
}

ordered_json boards_json(const CalibFolderOptions& options, const ExtrinsicFit& fit,
                         const PmdBoardViews& found) {
  ordered_json json = place_json(options, fit);
  json["misfit"] = fit.misfit;
  json["views"] = ordered_json::array();
  for (std::size_t n = 0; n < found.views.size(); ++n) {
    json["views"].push_back(
        {{"name", found.views[n].pair.name}, {"off_sigmas", fit.wall_misfit[n]}});
  }
  json["left_out"] = found.refused;
  return json;
}

// The place, and what is printed of it once it is written where JSON is asked for.
struct Placed {
  ExtrinsicFit fit;
  ordered_json json;
};

Placed by_walls(const CalibFolderOptions& options, const dsp::Calibration& rig) {
  const FoundWalls found =
      walls_of(value_or_fail(read_looks(options.folder, rig, search_of(options))));
  const std::vector<std::string> missing = missing_tilts(found.walls);
  const std::optional<ExtrinsicFit> fit =
      fit_extrinsics(found.walls, {.offset_sigma_m = options.offset_mm / kMmPerMetre});
  if (!options.json) {
    if (fit) {
      std::printf("%s", extrinsics_text(*fit, found).c_str());
    }
    print("left out", found.refused);
    print("missing", missing);
  }
  if (!fit || (!missing.empty() && !options.force)) {
    throw Failure(
        Exit::kBadInput,
        options.folder.string() + ": " +
            (missing.empty() ? "the walls do not tell where the PMD camera is" : missing.front()) +
            ": add such walls, no file is written" + (fit ? "; or give --force" : ""));
  }
  if (const std::string why = fit->contradiction(); !why.empty() && !options.force) {
    throw Failure(Exit::kBadInput,
                  options.folder.string() + ": " + why +
                      ": calibrate the PMD camera anew (stof calib pmd) before walls that face it, "
                      "keep these walls free and flat, no file is written; or give --force");
  }
  return {*fit, walls_json(options, *fit, found, missing)};
}

// The board that a PMD camera can see, or Failure.
Board pmd_board(const CalibFolderOptions& options, const dsp::Calibration& rig) {
  if (rig.stereo.converging) {
    throw Failure(Exit::kBadInput, options.calibration.string() +
                                       ": is of a pair whose axes converge: use walls, without "
                                       "--board");
  }
  const Board board = value_or_fail(board_named(options.board));
  if (board.has_markers()) {
    throw Failure(Exit::kBadInput, "--board " + options.board +
                                       ": has markers, too fine for a PMD camera: use a chessboard "
                                       "of large squares");
  }
  return board;
}

Placed by_boards(const CalibFolderOptions& options, const dsp::Calibration& rig) {
  const Board board = pmd_board(options, rig);
  const PmdBoardViews found = value_or_fail(read_board_views(options.folder, rig, board));
  if (!options.json) {
    print("left out", found.refused);
  }
  const std::optional<ExtrinsicFit> fit =
      fit_extrinsics(board, found.views, fixed_pair(rig.stereo), rig.pmd.lens);
  if (!fit) {
    throw Failure(Exit::kBadInput, options.folder.string() +
                                       ": more: " + std::to_string(found.views.size()) +
                                       " views show the whole board to all three cameras, 5 are "
                                       "needed: add such views");
  }
  if (!options.json) {
    std::printf("%s", board_extrinsics_text(*fit, found).c_str());
  }
  if (const std::string why = contradiction_of_views(*fit); !why.empty() && !options.force) {
    throw Failure(Exit::kBadInput,
                  options.folder.string() + ": " + why +
                      ": give the lens of this PMD camera (stof calib pmd --lens), hold the board "
                      "still, no file is written; or give --force");
  }
  return {*fit, boards_json(options, *fit, found)};
}

ordered_json check_json(const RigCheck& check) {
  ordered_json json{{"rows", nullptr}, {"depths", nullptr}};
  if (check.rows) {
    json["rows"] = {{"points", check.rows->points},
                    {"median_px", check.rows->median_px},
                    {"rms_px", check.rows->rms_px},
                    {"slope_px", check.rows->slope_px}};
  }
  if (check.depths) {
    json["depths"] = {{"points", check.depths->points},
                      {"median_mm", check.depths->median_mm},
                      {"spread_mm", check.depths->spread_mm},
                      {"turn_shows_deg", ordered_json::array()}};
    for (const double degrees : check.depths->turn_shows_deg) {
      json["depths"]["turn_shows_deg"].push_back(number_or_null(degrees));
    }
  }
  return json;
}

}  // namespace

void calib_extrinsics(const CalibFolderOptions& options) {
  refuse_two_sources("calib extrinsics", options);
  StoredCalibration stored = rig_of(options.calibration);
  dsp::Calibration& rig = stored.calibration;
  if (rig.pmd.lens.width == 0) {
    throw Failure(Exit::kBadInput,
                  options.calibration.string() +
                      ": holds no PMD camera: calibrate it first (stof calib pmd)");
  }
  need_file(options.out, "--out");
  need_calibration_out(options.out);
  if (!options.board.empty()) {
    pmd_board(options, rig);  // before a sensor is asked
  }
  CalibFolderOptions from = options;
  if (options.live.on()) {
    from.folder = calib_live_walls(options, rig);
  }
  const Placed placed = options.board.empty() ? by_walls(from, rig) : by_boards(from, rig);
  rig.pmd_to_stereo = transform_of(placed.fit.pmd_to_stereo);
  value_or_end(write_calibration(options.out, rig));
  if (options.json) {
    say_json(placed.json);
  } else {
    std::printf("%s\n", options.out.c_str());
  }
}

void calib_check(const CalibFolderOptions& options) {
  refuse_two_sources("calib check", options);
  const StoredCalibration stored = rig_of(options.calibration);
  const std::filesystem::path folder =
      options.live.on() ? calib_live_pictures(options, stored.calibration) : options.folder;
  const RigCheck check = value_or_fail(check_rig(folder, stored.calibration, search_of(options)));
  const std::vector<std::string> lines = advice(check);
  if (options.json) {
    ordered_json json = check_json(check);
    json["folder"] = folder.string();
    json["calibration"] = options.calibration.string();
    json["advice"] = lines;
    json["not_judged"] = doubts(check);
    say_json(json);
  } else {
    say_text(check_text(check));
  }
  if (!lines.empty()) {
    throw Failure(Exit::kFailure, options.calibration.string() + ": " + lines.front());
  }
}

}  // namespace stof::host
