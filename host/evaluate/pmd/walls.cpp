#include "host/evaluate/pmd/walls.h"

#include <algorithm>
#include <cmath>

#include "dataset/files/file.h"
#include "host/calibrate/walls/wall_folder.h"

namespace stof::host {
namespace {

constexpr double kShownM = 2;  // walls of about this distance are drawn

// The recordings' own constants, with the phasor alone estimated from the chosen frames.
std::expected<void, dataset::Problem> study_stray(const WallFolder& folder,
                                                  const PmdSources& sources, Frames fitted,
                                                  WallStudy& study) {
  const dataset::Loaded<PmdScene> scene = read_pmd_scene(folder.prefixes.front(), sources);
  if (!scene) {
    return std::unexpected(scene.error());
  }
  const dsp::PmdSensor own = scene->recording.calibration.pmd;
  const CalibrateOptions options{.parts = {.offset = false,
                                           .scale = false,
                                           .wiggling = false,
                                           .pattern = false,
                                           .stray = true,
                                           .emitter = false},
                                 .noise = false,
                                 .white = false,
                                 .start = own,
                                 .phase_falls = own.phase_falls};
  const dataset::Loaded<PmdCalibration> found =
      calibrate_pmd(own, std::vector<Wall>(folder.walls), options);
  if (!found) {
    return dataset::refuse(folder.prefixes.front().parent_path().string() + ": " +
                           found.error().message);
  }
  study.stray_i_lsb = found->stray.estimate.real();
  study.stray_q_lsb = found->stray.estimate.imag();
  study.stray_sigma_lsb = found->stray.sigma;
  study.stray_apparent_m = found->stray.apparent_m;
  dsp::PmdSensor with = own;
  with.frequency.stray_i_lsb = study.stray_i_lsb;
  with.frequency.stray_q_lsb = study.stray_q_lsb;
  for (std::size_t n = 0; n < folder.prefixes.size(); ++n) {
    const dataset::Loaded<WallRecording> wall = read_again(folder, n);
    if (!wall) {
      return std::unexpected(wall.error());
    }
    study.stray.push_back({.name = wall->name,
                           .z_m = wall->z_m,
                           .before = view_wall(own, *wall, others(fitted)),
                           .after = view_wall(with, *wall, others(fitted))});
  }
  std::ranges::sort(study.stray, {}, &StrayRow::z_m);
  return {};
}

// The wall that is drawn, before any calibration and after.
std::expected<void, dataset::Problem> add_shown(const WallFolder& folder, WallStudy& study) {
  const auto distance = [](const WallRow& row) { return std::abs(row.z_m - kShownM); };
  const auto shown = std::ranges::min_element(study.report.rows, {}, distance);
  if (shown == study.report.rows.end()) {
    return {};
  }
  dsp::PmdSensor bare = study.calibration.sensor;
  bare.frequency.wiggling = {};
  bare.frequency.stray_i_lsb = bare.frequency.stray_q_lsb = 0;
  bare.fixed_pattern = {};
  bare.emitter_count = 0;
  bare.scale = 1;
  bare.frequency.offset_m = bare.shift_m = 0;
  for (std::size_t n = 0; n < folder.prefixes.size(); ++n) {
    const dataset::Loaded<WallRecording> wall = read_again(folder, n);
    if (!wall) {
      return std::unexpected(wall.error());
    }
    if (wall->name == shown->name) {
      study.shown_m = wall->z_m;
      study.plain = view_wall(bare, *wall, study.report.judged);
      study.full = shown->view;
      return {};
    }
  }
  return {};
}

}  // namespace

const std::array<const char*, kPmdFlags>& pmd_flag_names() {
  static constexpr std::array<const char*, kPmdFlags> kNames{
      "saturated",  "under range", "low amplitude", "low ratio",
      "asymmetric", "edge",        "out of range",  "wrapped"};
  return kNames;
}

dataset::Loaded<WallStudy> study_walls(const PmdSet& set, const PmdSources& sources,
                                       Frames fitted) {
  const dataset::Loaded<WallFolder> folder = read_folder(set.folder, fitted);
  if (!folder) {
    return std::unexpected(folder.error());
  }
  dataset::Loaded<PmdCalibration> found =
      calibrate_pmd(folder->calibration.pmd, std::vector<Wall>(folder->walls), CalibrateOptions{});
  if (!found) {
    return dataset::refuse(set.folder.string() + ": " + found.error().message);
  }
  WallStudy study;
  study.folder = set.folder;
  study.calibration = std::move(*found);
  if (sources.calibration) {
    const dsp::PmdSensor& known = *sources.calibration;
    const dsp::PmdSensor& own = study.calibration.sensor;
    study.given = known.lens.width == own.lens.width && known.lens.height == own.lens.height &&
                  known.frequency.modulation.value == own.frequency.modulation.value;
    study.calibration.sensor = study.given ? known : own;
  }
  const Frames judged_by = study.given ? Frames::kAll : fitted;
  dataset::Loaded<PmdReport> report = make_report(*folder, judged_by, study.calibration);
  if (!report) {
    return std::unexpected(std::move(report.error()));
  }
  study.report = std::move(*report);
  study.report.folder = set.folder.string();
  if (auto viewed = add_shown(*folder, study); !viewed) {
    return std::unexpected(std::move(viewed.error()));
  }
  if (study.calibration.stray.verdict == StrayVerdict::kCorrected) {
    if (auto looked = study_stray(*folder, sources, fitted, study); !looked) {
      return std::unexpected(std::move(looked.error()));
    }
  }
  return study;
}

}  // namespace stof::host
