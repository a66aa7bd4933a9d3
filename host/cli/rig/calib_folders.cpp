#include <cstdio>

#include "host/calibrate/calibration_store.h"
#include "host/calibrate/rig/report/rig_report.h"
#include "host/cli/failure.h"
#include "host/cli/rig/calib_rig.h"

namespace stof::host {
namespace {

constexpr double kMmPerMetre = 1000;

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

}  // namespace

void calib_extrinsics(const CalibFolderOptions& options) {
  StoredCalibration stored = rig_of(options.calibration);
  dsp::Calibration& rig = stored.calibration;
  if (rig.pmd.lens.width == 0) {
    throw Failure(Exit::kBadInput,
                  options.calibration.string() +
                      ": holds no PMD camera: calibrate it first (stof calib pmd)");
  }
  const FoundWalls found =
      walls_of(value_or_fail(read_looks(options.folder, rig, search_of(options))));
  const std::vector<std::string> missing = missing_tilts(found.walls);
  const std::optional<ExtrinsicFit> fit =
      fit_extrinsics(found.walls, {.offset_sigma_m = options.offset_mm / kMmPerMetre});
  if (fit) {
    std::printf("%s", extrinsics_text(*fit, found).c_str());
  } else {
    for (const std::string& line : found.refused) {
      std::printf("left out: %s\n", line.c_str());
    }
  }
  for (const std::string& line : missing) {
    std::printf("missing: %s\n", line.c_str());
  }
  if (!fit || (!missing.empty() && !options.force)) {
    throw Failure(
        Exit::kBadInput,
        options.folder.string() + ": " +
            (missing.empty() ? "the walls do not tell where the PMD camera is" : missing.front()) +
            ": add such walls, no file is written" + (fit ? "; or give --force" : ""));
  }
  rig.pmd_to_stereo = transform_of(fit->pmd_to_stereo);
  value_or_fail(write_calibration(options.out, rig));
  std::printf("%s\n", options.out.c_str());
}

void calib_check(const CalibFolderOptions& options) {
  const StoredCalibration stored = rig_of(options.calibration);
  const RigCheck check =
      value_or_fail(check_rig(options.folder, stored.calibration, search_of(options)));
  std::printf("%s", check_text(check).c_str());
  const std::vector<std::string> lines = advice(check);
  if (!lines.empty()) {
    throw Failure(Exit::kFailure, options.calibration.string() + ": " + lines.front());
  }
}

}  // namespace stof::host
