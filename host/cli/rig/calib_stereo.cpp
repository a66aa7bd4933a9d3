#include <cstdio>

#include "host/calibrate/calibration_store.h"
#include "host/calibrate/rig/report/rig_report.h"
#include "host/cli/calib_files.h"
#include "host/cli/failure.h"
#include "host/cli/json_output.h"
#include "host/cli/output.h"
#include "host/cli/own_keys.h"
#include "host/cli/rig/live_stereo_json.h"
#include "host/cli/rig/live_views.h"
#include "host/cli/rig/stereo_json.h"

namespace stof::host {
namespace {

constexpr double kUmPerMetre = 1e6;

dsp::Calibration start_of(const CalibStereoOptions& options, StoredCalibration& stored) {
  if (options.start.empty()) {
    return {};
  }
  stored = value_or_fail(read_calibration(options.start));
  return stored.calibration;
}

TargetOptions target_options(const CalibStereoOptions& options) {
  TargetOptions target{.board = value_or_fail(board_named(options.board))};
  target.most_blur_px = options.most_blur_px;
  if (options.hold_out >= 0) {
    target.hold_out = options.hold_out;
  }
  return target;
}

TargetCalibration of_folder(const CalibStereoOptions& options, const TargetOptions& target) {
  TargetViews views = value_or_fail(find_views(options.target, target));
  if (const std::string why = unseen(views, target.board); !why.empty()) {
    throw Failure(Exit::kBadInput, options.target.string() + ": " + why);
  }
  const std::vector<RefusedView> refused = views.refused;
  dataset::Loaded<TargetCalibration> found = calibrate_target(std::move(views), target);
  if (!found) {
    if (!options.json) {
      for (const RefusedView& view : refused) {
        std::printf("left out: %s: %s\n", view.name.c_str(), view.why.c_str());
      }
    }
    throw Failure(Exit::kBadInput, options.target.string() + ": " + found.error().message);
  }
  return std::move(*found);
}

void by_target(const CalibStereoOptions& options) {
  const TargetOptions target = target_options(options);
  StoredCalibration stored;
  const dsp::Calibration start = start_of(options, stored);
  const std::filesystem::path folder =
      options.live.on() ? live_folder(options.live, options.out, ".views") : options.target;
  TargetCalibration found =
      options.live.on() ? calib_live_stereo(options, target) : of_folder(options, target);
  if (std::string note = other_scale(start, found.fit.rig); !note.empty()) {
    found.notes.push_back(std::move(note));
  }
  if (!options.json) {
    std::printf("%s", target_text(found).c_str());
  }
  if (!options.page.empty()) {
    value_or_end(write_target_page(found, options.page));
  }
  if (!found.missing.empty() && !options.force) {
    throw Failure(Exit::kBadInput, folder.string() + ": " + found.missing.front() +
                                       ": add such views, no file is written; or give --force");
  }
  if (const std::string why = other_rig(start, found.fit.rig); !why.empty() && !options.force) {
    throw Failure(Exit::kBadInput,
                  options.start.string() + ": " + why + "; or give --force, no file is written");
  }
  value_or_end(write_calibration(options.out, with_pair(start, found.fit.rig)));
  if (!options.json) {
    std::printf("%s\n", options.out.c_str());
  } else if (options.live.on()) {
    nlohmann::ordered_json line = stage_json("calibrated", options.out.string() + " is written");
    line["result"] = target_json(options, folder, found);
    say_json_line(line);
  } else {
    say_json(target_json(options, folder, found));
  }
}

double second_or(const std::vector<double>& numbers, double share) {
  return numbers.size() > 1 ? numbers[1] : numbers[0] * share;
}

PlaneCalibrationOptions plane_options(const CalibStereoOptions& options, int width, int height) {
  PlaneCalibrationOptions made;
  constexpr double kBaselineShare = 0.01;
  constexpr double kFocalShare = 0.02;
  made.priors.baseline_m = options.baseline[0];
  made.priors.baseline_sigma_m = second_or(options.baseline, kBaselineShare);
  made.priors.focal_m = options.focal[0] / kMmPerMetre;
  made.priors.focal_sigma = second_or(options.focal, kFocalShare) / options.focal[0];
  if (!(made.priors.baseline_m > 0) || !(made.priors.baseline_sigma_m > 0) ||
      !(made.priors.focal_m > 0) || !(made.priors.focal_sigma > 0)) {
    throw Failure(Exit::kBadInput,
                  "--baseline, --focal: take a positive number and its standard deviation: give "
                  "such as --baseline 0.2 0.002");
  }
  made.sensor.pixel_m = options.pixel_um / kUmPerMetre;
  const double middle = (width - 1) / 2.0;
  made.sensor.cx_left = options.centre.empty() ? middle : options.centre[0];
  made.sensor.cx_right = options.centre.empty() ? middle : options.centre[1];
  made.sensor.cy = options.centre.empty() ? (height - 1) / 2.0 : options.centre[2];
  made.genes.seed = options.seed;
  made.chapter = options.chapter;
  if (options.hold_out >= 0) {
    made.hold_out = options.hold_out;
  }
  return made;
}

void by_planes(const CalibStereoOptions& options) {
  StoredCalibration stored;
  dsp::Calibration rig = start_of(options, stored);
  const PlaneOptions search{.min_disparity = options.min_disparity,
                            .disparities = options.disparities,
                            .block = options.block,
                            .threads = options.threads};
  if (options.live.on()) {
    calib_live_planes(options, search);
  }
  const std::vector<Plane> planes = value_or_fail(read_planes(options.planes, search));
  const int width = planes.front().disparity.width;
  const int height = planes.front().disparity.height;
  const PlaneCalibrationOptions plane = plane_options(options, width, height);
  const PlaneCalibration found = value_or_fail(calibrate_planes(planes, plane));
  if (!options.json) {
    std::printf("%s", planes_text(found).c_str());
  }
  rig.stereo = rig_of(found.fit.x, plane.sensor, width, height);
  value_or_end(write_calibration(options.out, rig));
  if (options.json) {
    say_json(planes_json(options, found));
  } else {
    std::printf("%s\n", options.out.c_str());
  }
}

}  // namespace

void calib_stereo(const CalibStereoOptions& options) {
  const int sources = (options.target.empty() ? 0 : 1) + (options.planes.empty() ? 0 : 1) +
                      (options.live.on() && options.distances.empty() ? 1 : 0);
  const bool walls_live = options.live.on() && !options.planes.empty();
  if (!options.distances.empty() && !walls_live) {
    throw Failure(Exit::kBadInput,
                  "--distances: are of walls before a live sensor: give --planes DIR and --live "
                  "SENSOR too");
  }
  if (sources != 1) {
    throw Failure(Exit::kBadInput,
                  "calib stereo: from what: give one of --target DIR, --live SENSOR and --planes "
                  "DIR");
  }
  need_file(options.out, "--out");
  need_calibration_out(options.out);
  if (!options.page.empty()) {
    need_file(options.page, "--html");
    need_other_file(options.page, "--html", {options.out, options.start});
  }
  options.planes.empty() ? by_target(options) : by_planes(options);
}

}  // namespace stof::host
