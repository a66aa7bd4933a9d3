#include "host/cli/rig/calib_rig.h"

#include <cstdio>

#include "dataset/dataset.h"
#include "dataset/files/file.h"
#include "host/calibrate/calibration_store.h"
#include "host/calibrate/rig/target/target_sheet.h"
#include "host/cli/calib_files.h"
#include "host/cli/failure.h"
#include "host/cli/help_text.h"
#include "host/cli/json_output.h"
#include "host/cli/output.h"
#include "host/cli/own_keys.h"

namespace stof::host {
namespace {

constexpr const char* kCalibEnds =
    "Ends with 0 (the file is written), 1 (stopped, the sensor sent nothing, fell silent, or has "
    "no PMD camera that is asked for; views are kept. Or the disk is full) or 2 (bad input, views "
    "are missing, or the file cannot be made).";
constexpr const char* kFileEnds =
    "Ends with 0 (the file is written), 1 (the disk is full) or 2 (bad input, or the file cannot "
    "be made).";

void add_out(CLI::App& command, std::filesystem::path& out) {
  command.add_option("--out", out, "The calibration file to write")->required();
}

void add_start(CLI::App& command, std::filesystem::path& start) {
  command.add_option("--start", start,
                     "Calibration file of the rig so far; its PMD camera is kept");
}

void add_search(CLI::App& command, int& min_disparity, int& disparities, int& threads) {
  command.add_option("--min-disparity", min_disparity, "First disparity looked at, px")
      ->check(CLI::Range(-1024, 1024))
      ->capture_default_str();
  command.add_option("--disparities", disparities, "How many")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command.add_option("--threads", threads, "Threads that match")
      ->check(CLI::Range(1, 8))
      ->capture_default_str();
}

void add_board(CLI::App& command, std::string& board) {
  command
      .add_option("--board", board,
                  "COLUMNSxROWS:SQUARE_M of a chessboard: its inner corners, and a square as "
                  "measured on the print; charuco:COLUMNSxROWS:SQUARE_M[:MARKER_M[:4x4]]; "
                  "aprilgrid:COLUMNSxROWS:TAG_M:GAP of tags, the gap as share of a tag")
      ->capture_default_str();
}

// --live and its own. `shows`: what the sensor is to show.
void add_live(CLI::App& command, CalibLiveOptions& live, const char* shows, bool holds_still) {
  CLI::Option* const sensor = command.add_option(
      "--live", live.sensor, std::string("HOST[:PORT] of a sensor that shows ") + shows);
  command
      .add_option("--keep", live.keep,
                  "--live: folder for the views, read on by a run after this one; default: beside "
                  "the calibration file")
      ->needs(sensor);
  command.add_option("--views", live.views, "--live: how many views are wanted at least")
      ->needs(sensor)
      ->check(CLI::Range(1, 60))
      ->capture_default_str();
  command
      .add_option("--time-limit", live.time_limit_s,
                  "--live: seconds, after which it ends with what it has")
      ->needs(sensor)
      ->check(CLI::Range(1.0, 86'400.0))
      ->capture_default_str();
  command
      .add_option("--raw-every", live.every, "--live: one exposure of so many frames is looked at")
      ->needs(sensor)
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  if (holds_still) {
    command
        .add_option("--max-motion", live.most_motion_px,
                    "--live: px between successive exposures; what moves by more is not taken")
        ->needs(sensor)
        ->check(CLI::Range(0.05, 20.0))
        ->capture_default_str();
  }
  add_subscription_flags(command, live);
}

void add_planes_flags(CLI::App& command, CalibStereoOptions& options) {
  command
      .add_option("--baseline", options.baseline,
                  "--planes: baseline by the tape, and its standard deviation, metres")
      ->expected(1, 2)
      ->capture_default_str();
  command
      .add_option("--focal", options.focal,
                  "--planes: focal length on the lens, and its standard deviation, mm")
      ->expected(1, 2)
      ->capture_default_str();
  command.add_option("--pixel", options.pixel_um, "--planes: width of a pixel, um")
      ->check(CLI::Range(0.5, 100.0))
      ->capture_default_str();
  command
      .add_option("--centre", options.centre,
                  "--planes: principal columns left and right, and row, px; default: the middle")
      ->expected(3);
  command
      .add_option(
          "--distances", options.distances,
          "--planes --live: of the walls, metres, separated by commas; those that DIR holds "
          "are not asked for again")
      ->delimiter(',')
      ->check(CLI::Range(0.06, 99.0));
  command.add_option("--block", options.block, "--planes: side of the matched blocks, px")
      ->check(CLI::Range(3, 64))
      ->capture_default_str();
  command.add_option("--seed", options.seed, "--planes: of the genetic algorithm")
      ->capture_default_str();
  command.add_flag("--chapter", options.chapter,
                   "--planes: the chapter's own objective too, and its Table 2 by it");
  add_search(command, options.min_disparity, options.disparities, options.threads);
}

void add_stereo(CLI::App& calib, CalibStereoOptions& options) {
  CLI::App& command = *calib.add_subcommand(
      "stereo", "A pair, from views of a board or from walls at known distances");
  show_example(command, calib_rig_example("stereo"), kCalibEnds);
  CLI::Option* const target =
      command.add_option("--target", options.target,
                         "Folder with a folder for each view of a board: left.pgm, right.pgm");
  CLI::Option* const planes = command.add_option(
      "--planes", options.planes,
      "Folder with a folder for each wall: left.pgm, right.pgm, meta.txt (plane_z_m)");
  target->excludes(planes);
  add_live(command, options.live, "a board that is waved", true);
  add_out(command, options.out);
  add_start(command, options.start);
  command
      .add_option("--hold-out", options.hold_out,
                  "One of so many views or walls judges and is not fitted to (5, 3); 0: none")
      ->check(CLI::Range(0, 100));
  command.add_flag("--force", options.force, "Write the file although views are missing");
  add_board(command, options.board);
  command
      .add_option("--max-blur", options.most_blur_px,
                  "--target, --live: views whose edges are smoothed by more px do not count")
      ->check(CLI::Range(0.1, 20.0))
      ->capture_default_str();
  command.add_option("--html", options.page,
                     "--target, --live: a page with the residuals of each view");
  add_json_flag(command, options.json);
  CLI::Option* const json = command.get_option("--json");
  json->description("JSON, and nothing else: of a board and --live an object a line, else one");
  command
      .add_option(
          "--picture-width", options.picture_width,
          "--live --json: both pictures of each exposure that was looked at, PNG in base64, "
          "so many px wide or less; 0: none")
      ->needs(json)
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  add_planes_flags(command, options);
  command.callback([&options] { calib_stereo(options); });
}

void add_extrinsics(CLI::App& calib, CalibFolderOptions& options) {
  CLI::App& command = *calib.add_subcommand(
      "extrinsics",
      "Where the PMD camera is, from walls at several tilts that both see, or a board");
  show_example(command, calib_rig_example("extrinsics"), kCalibEnds);
  command.add_option("DIR", options.folder,
                     "Folder with a folder for each wall: left.pgm, right.pgm, pmd.json, "
                     "pmd_raw.pgm");
  options.live.views = 8;
  add_live(command, options.live, "walls, or the board, at several tilts", true);
  command
      .add_option("--pmd-frames", options.live.pmd_frames,
                  "--live: exposures of the PMD camera for each view")
      ->check(CLI::Range(1, 200))
      ->capture_default_str();
  command.add_option("--calibration", options.calibration, "The rig's file so far")->required();
  add_out(command, options.out);
  command.add_option("--board", options.board,
                     "Views of this board in place of walls (COLUMNSxROWS:SQUARE_M)");
  command
      .add_option("--pmd-offset", options.offset_mm,
                  "How far PMD distances may be off, all alike: standard deviation, mm")
      ->check(CLI::Range(0.01, 1000.0))
      ->capture_default_str();
  command.add_flag("--force", options.force,
                   "Write the file although tilts are missing, or walls contradict each other");
  add_search(command, options.min_disparity, options.disparities, options.threads);
  add_json_flag(command, options.json);
  command.callback([&options] { calib_extrinsics(options); });
}

void add_check(CLI::App& calib, CalibFolderOptions& options) {
  CLI::App& command = *calib.add_subcommand(
      "check", "Whether a calibration still fits its rig; ends with 1 where it does not");
  show_example(command, calib_rig_example("check"),
               "Ends with 0 (it fits), 1 (something is to be done, or nothing came) or 2 (bad "
               "input).");
  command.add_option("DIR", options.folder,
                     "Folder with a folder for each exposure: left.pgm, right.pgm; may have "
                     "pmd.json, pmd_raw.pgm");
  options.live.views = 5;
  add_live(command, options.live, "anything with texture, from 1 to 4 m", false);
  command.add_option("--calibration", options.calibration, "The file to judge")->required();
  add_search(command, options.min_disparity, options.disparities, options.threads);
  add_json_flag(command, options.json);
  command.callback([&options] { calib_check(options); });
}

void add_exchange(CLI::App& calib, CalibRigOptions& options) {
  CLI::App& import = *calib.add_subcommand("import", "A pair from a file of ROS, Kalibr or OpenCV");
  show_example(import, calib_rig_example("import"), kFileEnds);
  import.add_option("FORMAT", options.import.format, "ros, kalibr or opencv")
      ->required()
      ->check(CLI::IsMember({"ros", "kalibr", "opencv"}));
  import
      .add_option("FILE", options.import.files,
                  "ros: left and right (YAML or INI), or an INI with both; kalibr: one;\n"
                  "opencv: one or two, YAML or JSON")
      ->required()
      ->expected(1, 2);
  add_out(import, options.import.out);
  add_start(import, options.import.start);
  import
      .add_option("--size", options.import.size,
                  "opencv: width and height of the pictures, where the file has none")
      ->expected(2)
      ->check(CLI::Range(2, 65536));
  add_json_flag(import, options.import.json);
  import.callback([&options] { calib_import(options.import); });

  CLI::App& to = *calib.add_subcommand("export", "The pair of a file, for ROS, Kalibr or OpenCV");
  show_example(to, calib_rig_example("export"), kFileEnds);
  to.add_option("FORMAT", options.export_to.format, "ros, kalibr or opencv")
      ->required()
      ->check(CLI::IsMember({"ros", "kalibr", "opencv"}));
  to.add_option("FILE", options.export_to.start, "A calibration file")->required();
  to.add_option("--out", options.export_to.out,
                "The file to write; ros: a folder, in which left.yaml and right.yaml are written")
      ->required();
  add_json_flag(to, options.export_to.json);
  to.callback([&options] { calib_export(options.export_to); });
}

void add_target(CLI::App& calib, CalibTargetOptions& options) {
  CLI::App& command =
      *calib.add_subcommand("target", "A board as PDF in true size, with a ruler to check it");
  show_example(command, calib_rig_example("target"), kFileEnds);
  add_board(command, options.board);
  command.add_option("--paper", options.paper, "a4, a3, a2, a1 or a0")->capture_default_str();
  command
      .add_option("--out", options.out,
                  "The PDF to write; or a .pgm: the board in few pixels, for the emulator")
      ->required();
  add_json_flag(command, options.json);
  command.callback([&options] { calib_target(options); });
}

}  // namespace

void calib_target(const CalibTargetOptions& options) {
  const bool pgm = options.out.extension() == ".pgm";
  if (!pgm && options.out.extension() != ".pdf") {
    throw Failure(Exit::kBadInput, "--out " + options.out.string() +
                                       ": is neither .pdf nor .pgm: give a name that ends so");
  }
  need_its_folder(options.out, "--out");
  need_file(options.out, "--out");
  need_out_of_kind(options.out, "--out", {}, pgm ? "PGM" : "PDF",
                   [&](std::string_view bytes) { return bytes.starts_with(pgm ? "P5" : "%PDF"); });
  const Board board = value_or_fail(board_named(options.board));
  if (pgm) {
    const std::optional<BoardPicture> made = picture_of(board);
    if (!made) {
      throw Failure(Exit::kBadInput, "board " + options.board +
                                         ": its markers are no simple share of a square: write a "
                                         "PDF, or use markers of 3/4 of a square");
    }
    value_or_end(dataset::write_pgm8(options.out, made->picture));
    if (options.json) {
      say_json({{"file", options.out.string()},
                {"board", to_string(board)},
                {"width", made->picture.width},
                {"height", made->picture.height},
                {"pixel_mm", made->pixel_mm}});
      return;
    }
    std::printf("%s: %dx%d, %g mm a pixel\n", options.out.c_str(), made->picture.width,
                made->picture.height, made->pixel_mm);
    return;
  }
  const Sheet sheet = value_or_fail(sheet_of(board, options.paper));
  value_or_end(dataset::write_whole(options.out, pdf_bytes(sheet)));
  if (options.json) {
    say_json({{"file", options.out.string()},
              {"board", to_string(board)},
              {"width_mm", sheet.width_mm},
              {"height_mm", sheet.height_mm}});
    return;
  }
  std::printf("%s: %g x %g mm; print at 100 percent, and measure a square\n", options.out.c_str(),
              sheet.width_mm, sheet.height_mm);
}

bool has_calib_rig() noexcept { return true; }

void add_calib_rig(CLI::App& calib, CalibRigOptions& options) {
  add_stereo(calib, options.stereo);
  add_extrinsics(calib, options.extrinsics);
  add_check(calib, options.check);
  add_exchange(calib, options);
  add_target(calib, options.target);
}

}  // namespace stof::host
