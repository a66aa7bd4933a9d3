#include "host/cli/calib.h"

#include <algorithm>
#include <cstdio>

#include "dataset/files/json_fields.h"
#include "host/calibrate/calibration_store.h"
#include "host/calibrate/report/pmd_json.h"
#include "host/calibrate/report/pmd_report.h"
#include "host/cli/calib_files.h"
#include "host/cli/failure.h"
#include "host/cli/help_text.h"
#include "host/cli/output.h"
#include "host/cli/own_keys.h"
#include "host/evaluate/other_camera.h"
#include "host/report/pmd/pmd_page.h"

namespace stof::host {
namespace {

// What --fit names; all of it where it names nothing.
void choose_parts(const CalibPmdOptions& options, CalibrateOptions& calibrate) {
  const auto named = [&options](const char* name) {
    return options.fit.empty() || std::ranges::find(options.fit, name) != options.fit.end();
  };
  calibrate.parts = {.offset = named("offset"),
                     .scale = named("scale"),
                     .wiggling = named("wiggling"),
                     .pattern = named("pattern"),
                     .stray = named("stray"),
                     .emitter = named("emitter") && !options.no_emitters,
                     .wall_turn = named("pattern")};
  calibrate.noise = named("noise");
  calibrate.white = named("white");
}

void put_lens(const std::vector<double>& numbers, dsp::Pinhole& lens) {
  const std::array<double*, 9> to{&lens.fx, &lens.fy, &lens.cx, &lens.cy, &lens.k1,
                                  &lens.k2, &lens.k3, &lens.p1, &lens.p2};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    *to[i] = numbers[i];
  }
}

// What files say was judged when they were read: what is wrong now comes from this flag.
void refuse_unusable(const dsp::PmdSensor& camera, const char* flag) {
  if (const std::string why =
          dataset::problem_of({.stereo = {}, .pmd = camera, .pmd_to_stereo = {}}, false);
      !why.empty()) {
    throw Failure(Exit::kBadInput, std::string(flag) + ": " + why + ": correct its numbers");
  }
}

void put_emitters(const CalibPmdOptions& options, dsp::PmdSensor& camera) {
  constexpr std::size_t kEach = 3;
  if (options.no_emitters) {
    camera.emitter_count = 0;
  }
  const std::vector<double>& numbers = options.emitters;
  if (numbers.empty()) {
    return;
  }
  if (numbers.size() % kEach != 0 || numbers.size() > kEach * dsp::kMaxEmitters) {
    throw Failure(Exit::kBadInput,
                  "--emitters: takes x y z of up to 4 lights, metres: give three numbers each");
  }
  camera.emitter_count = static_cast<int>(numbers.size() / kEach);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    camera.emitters[i / kEach][i % kEach] = numbers[i];
  }
}

void refuse_other_camera(const CalibPmdOptions& options, const dsp::PmdSensor& start,
                         const dsp::PmdSensor& camera) {
  if (start.lens.width != camera.lens.width || start.lens.height != camera.lens.height) {
    throw Failure(Exit::kBadInput,
                  options.start.string() + ": its PMD camera is " +
                      std::to_string(start.lens.width) + "x" + std::to_string(start.lens.height) +
                      ", the recordings are " + std::to_string(camera.lens.width) + "x" +
                      std::to_string(camera.lens.height) + ": use the calibration of this rig");
  }
  if (const std::string why = other_camera(start, camera); !why.empty()) {
    throw Failure(Exit::kBadInput,
                  options.start.string() + ": " + why + ": use the calibration of this rig");
  }
}

// The camera that is calibrated: what the recordings know, then --start, then the flags.
dsp::PmdSensor camera_of(const CalibPmdOptions& options, const WallFolder& folder,
                         const StoredCalibration& start) {
  dsp::PmdSensor camera = folder.calibration.pmd;
  const dsp::PmdSensor& known = start.calibration.pmd;
  if (!options.start.empty() && known.lens.width > 0) {
    refuse_other_camera(options, known, camera);
    camera.lens = known.lens;
    camera.min_amplitude_lsb = known.min_amplitude_lsb;
    if (camera.emitter_count == 0) {
      camera.emitter_count = known.emitter_count;
      camera.emitters = known.emitters;
    }
  }
  put_lens(options.lens, camera.lens);
  refuse_unusable(camera, "--lens");
  put_emitters(options, camera);
  refuse_unusable(camera, "--emitters");
  return camera;
}

// What the file lacks for a rig, or empty.
std::string missing_rig(const dsp::Calibration& calibration) {
  dsp::Calibration checked = calibration;
  if (*dsp::complete(checked.stereo) == '\0' && checked.stereo.left.width > 0 &&
      *dsp::problem(checked) == '\0') {
    return {};
  }
  return "note: the file has no complete stereo pair; stofd takes it once it has one (--start "
         "with the rig's calibration)\n";
}

// Of a live sensor, where its flags ask for it.
void record_live_walls(const CalibPmdOptions& options, const StoredCalibration& start) {
  if (options.live.on() == options.live.distances.empty()) {
    throw Failure(
        Exit::kBadInput,
        "calib pmd: --live and --distances: are of walls before a live sensor: give both");
  }
  if (!options.live.on()) {
    return;
  }
  if (start.calibration.pmd.lens.width == 0) {
    throw Failure(Exit::kBadInput,
                  (options.start.empty() ? "calib pmd: --live"
                                         : options.start.string() + ": has no PMD camera") +
                      std::string(": give --start with a file of this rig, such as its drawing, "
                                  "that knows the PMD camera's lens"));
  }
  need_file(options.out, "--out");
  record_pmd_walls(options.live, options.folder, options.start, start.calibration.pmd,
                   options.json);
}

}  // namespace

void calib_pmd(const CalibPmdOptions& options) {
  need_calibration_out(options.out);
  if (!options.plots.empty()) {
    need_folder(options.plots, "--plots");
  }
  StoredCalibration start;
  if (!options.start.empty()) {
    start = value_or_fail(read_calibration(options.start));
  }
  record_live_walls(options, start);
  const Frames frames = frames_named(options.frames);
  WallFolder folder = value_or_fail(read_folder(options.folder, frames));
  const dsp::PmdSensor camera = camera_of(options, folder, start);
  CalibrateOptions calibrate{
      .parts = {}, .albedo = options.albedo, .start = std::nullopt, .phase_falls = std::nullopt};
  choose_parts(options, calibrate);
  if (!options.start.empty() && start.calibration.pmd.lens.width > 0) {
    calibrate.start = start.calibration.pmd;
  }
  if (options.phase != "auto") {
    calibrate.phase_falls = options.phase == "falls";
  }
  dataset::Loaded<PmdCalibration> found = calibrate_pmd(camera, std::move(folder.walls), calibrate);
  if (!found) {
    throw Failure(Exit::kBadInput, options.folder.string() + ": " + found.error().message);
  }
  PmdReport report = value_or_fail(make_report(folder, frames, *found));
  report.folder = options.folder.string();

  dsp::Calibration rig = options.start.empty() ? folder.calibration : start.calibration;
  rig.pmd = found->sensor;
  const bool written = options.force || found->explains_the_walls();
  if (written) {
    value_or_end(write_calibration(options.out, rig));
  }
  if (!options.plots.empty()) {
    value_or_end(write_calibration_page(report, *found, options.plots / "calibration.html"));
  }
  if (options.json) {
    std::printf("%s\n", report_json(report, *found).c_str());
  } else {
    std::printf("%s", report_text(report, *found).c_str());
  }
  if (!written && !found->wrong_walls.empty()) {
    throw Failure(Exit::kBadInput,
                  options.folder.string() +
                      ": the model does not explain these walls, no file is written: " +
                      wrong_walls_text(found->wrong_walls) +
                      ": measure again, and correct z_m or take the wall out; or give --force");
  }
  if (!written) {
    throw Failure(Exit::kBadInput,
                  options.folder.string() +
                      ": the model does not explain these walls, no file is written: check their "
                      "distances, that they face the camera, and reflections; or give --force");
  }
  if (!options.json) {
    std::printf("%s%s\n", missing_rig(rig).c_str(), options.out.c_str());
  }
}

void add_calib(CLI::App& app, CalibPmdOptions& options, CalibInstallOptions& install,
               CalibRigOptions& rig) {
  CLI::App& calib = *app.add_subcommand("calib", "Calibrate the sensors of a rig");
  calib.require_subcommand(1);
  CLI::App& pmd = *calib.add_subcommand(
      "pmd", "A PMD sensor from a wall at known distances (docs/CALIBRATION.md)");
  show_example(
      pmd, "stof calib pmd walls --start rig.cal --out rig.cal --frames even",
      "Ends with 0 (the file is written), 1 (--live: stopped, or the sensor sent nothing, fell "
      "silent or has no PMD camera; walls are kept. Or the disk is full) or 2 (bad input, walls "
      "that the model does not explain, or a file that cannot be made).");
  pmd.add_option("DIR", options.folder, "Folder of the recordings; each json says \"z_m\"")
      ->required();
  pmd.add_option("--out", options.out, "The calibration file to write")->required();
  pmd.add_option("--start", options.start,
                 "Calibration file that everything is kept from that is not fitted");
  CLI::Option* const sensor = pmd.add_option(
      "--live", options.live.sensor,
      "HOST[:PORT] of a sensor before which a wall is put at each of --distances; DIR keeps the "
      "recordings. --start knows the lens");
  pmd.add_option("--distances", options.live.distances,
                 "--live: of the walls, metres, separated by commas; those that DIR holds are not "
                 "asked for again")
      ->needs(sensor)
      ->delimiter(',')
      ->check(CLI::Range(0.05, 100.0));
  pmd.add_option("--exposures", options.live.exposures, "--live: of each wall")
      ->needs(sensor)
      ->check(CLI::Range(1, 200))
      ->capture_default_str();
  add_subscription_flags(pmd, options.live);
  pmd.add_option("--frames", options.frames, "Frames that are fitted to; the others judge")
      ->check(CLI::IsMember(kFramesNames))
      ->capture_default_str();
  pmd.add_option("--fit", options.fit, "What is fitted, separated by commas; all of it by default")
      ->delimiter(',')
      ->check(CLI::IsMember(
          {"offset", "scale", "wiggling", "pattern", "stray", "emitter", "noise", "white"}));
  pmd.add_option("--phase", options.phase, "Whether the phase rises or falls with distance")
      ->check(CLI::IsMember({"auto", "rises", "falls"}))
      ->capture_default_str();
  pmd.add_option("--lens", options.lens, "fx fy cx cy [k1 k2 k3 p1 p2] in place of the json's")
      ->expected(4, 9);
  CLI::Option* const lights =
      pmd.add_option("--emitters", options.emitters, "x y z of each light in lens axes, metres")
          ->expected(3, 12);
  pmd.add_flag("--no-emitters", options.no_emitters, "The lights are at the lens")
      ->excludes(lights);
  pmd.add_option("--albedo", options.albedo, "Of the wall at the light's wavelength")
      ->check(CLI::Range(0.01, 1.0))
      ->capture_default_str();
  pmd.add_option("--plots", options.plots, "Folder for calibration.html, a page with plots");
  pmd.add_flag("--force", options.force,
               "Write the file although the model does not explain the walls");
  pmd.add_flag("--json", options.json, "Print JSON");
  pmd.callback([&options] { calib_pmd(options); });
  add_calib_install(calib, install);
  add_calib_rig(calib, rig);
}

}  // namespace stof::host
