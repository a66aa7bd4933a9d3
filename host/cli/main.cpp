#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <span>
#include <string>

#include "host/cli/address.h"
#include "host/cli/bridge/bridge.h"
#include "host/cli/calib.h"
#include "host/cli/completion.h"
#include "host/cli/config/config.h"
#include "host/cli/discover.h"
#include "host/cli/evaluate/evaluate.h"
#include "host/cli/evaluate/evaluate_chapter.h"
#include "host/cli/evaluate/evaluate_floor.h"
#include "host/cli/evaluate/evaluate_fusion.h"
#include "host/cli/evaluate/evaluate_pmd.h"
#include "host/cli/evaluate/evaluate_sequence.h"
#include "host/cli/evaluate/evaluate_stereo.h"
#include "host/cli/failure.h"
#include "host/cli/fault.h"
#include "host/cli/finite_numbers.h"
#include "host/cli/help_text.h"
#include "host/cli/output.h"
#include "host/cli/pair.h"
#include "host/cli/proxy.h"
#include "host/cli/recording/export.h"
#include "host/cli/recording/info.h"
#include "host/cli/recording/record.h"
#include "host/cli/recording/recover.h"
#include "host/cli/recording/replay.h"
#include "host/cli/sensor/check.h"
#include "host/cli/sensor/find_sensor.h"
#include "host/cli/sensor/health.h"
#include "host/cli/sensor/stats.h"
#include "host/cli/sensor/support_report.h"
#include "host/cli/update.h"
#include "host/cli/view/raw_flags.h"
#include "host/cli/view/replay.h"
#include "host/cli/view/view.h"
#include "host/cli/words.h"
#include "posix/out_of_resources.h"

namespace stof::host {
namespace {

constexpr const char* kVersion = "stof " STOF_VERSION;
constexpr const char* kFooter =
    "Example: stof discover\nExample: stof view 192.168.1.20\nExample: stof check 192.168.1.20\n"
    "Ends with 0 (done), 1 (nothing or too little was received, or the output cannot be written) "
    "or 2 (bad input: one line says what). Each command's --help says more.";

struct Commands {
  EvaluateStereoOptions stereo;
  EvaluateFusionOptions fusion;
  EvaluatePmdOptions pmd;
  EvaluateFloorOptions floor;
  EvaluateSequenceOptions sequence;
  ViewOptions view;
  ReportOptions chapter;
  CompletionOptions completion;
  StatsOptions stats;
  HealthOptions health;
  CheckOptions check;
  SupportReportOptions report;
  CalibPmdOptions calib_pmd;
  CalibInstallOptions calib_install;
  CalibRigOptions calib_rig;
  AddressOptions address;
  ConfigOptions config;
  DiscoverCommand discover;
  FaultOptions fault;
  PairOptions pair;
  UnpairOptions unpair;
  UpdateOptions update;
  ProxyOptions proxy;
  RecordOptions record;
  InfoOptions info;
  RecoverOptions recover;
  ExportOptions exported;
  ReplayOptions replay;
  BridgeOptions bridge;
};

void add_evaluate(CLI::App& app, Commands& commands) {
  CLI::App& evaluate =
      *app.add_subcommand("evaluate", "Score recorded scenes against their ground truth");
  evaluate.require_subcommand(1);

  EvaluateStereoOptions& stereo = commands.stereo;
  CLI::App& pair =
      *evaluate.add_subcommand("stereo", "Match stereo pairs: time, bad pixels, density");
  show_example(pair, "stof evaluate stereo stereo/Cones stereo/Teddy --preset quality", kFilesEnds);
  pair.add_option("DIR", stereo.scenes, "Folders with left.pgm, right.pgm, meta.txt")->required();
  add_evaluate_flags(pair, stereo, Judged::kDisparity);
  add_out_flag(pair, stereo);
  add_runs_flag(pair, stereo);
  pair.callback([&stereo] { evaluate_stereo(stereo); });

  EvaluateFusionOptions& fusion = commands.fusion;
  CLI::App& both =
      *evaluate.add_subcommand("fusion", "Fuse stereo pairs with their PMD recordings");
  show_example(both, "stof evaluate fusion stereo/Cones tof/sim/scene/Cones_176x144", kFilesEnds);
  add_fusion_flags(both, fusion);
  both.callback([&fusion] { evaluate_fusion(fusion); });

  add_evaluate_pmd(evaluate, commands.pmd);
  add_evaluate_floor(evaluate, commands.floor);
  add_evaluate_sequence(evaluate, commands.sequence);
  add_evaluate_chapter(evaluate, commands.chapter);
}

void add_view(CLI::App& app, ViewOptions& options) {
  CLI::App& view_command = *app.add_subcommand(
      "view", "Receive depth: a page in the browser, a line a second, pictures");
  show_example(view_command, "stof view 192.168.1.20");
  view_command
      .add_option("SENSOR", options.sensor,
                  std::string(kSensorOrFile) + "; none: listen for a sensor that sends here")
      ->check(not_empty());
  add_receive_flags(view_command, options, KeyUse::kPage);
  view_command
      .add_option("--frames", options.frames, "End after so many frames; 0: when interrupted")
      ->capture_default_str();
  view_command.add_option("--out", options.out, "Folder for depth.png, depth_color.png, cloud.ply");
  view_command.add_option("--headless", options.headless,
                          "Folder for depth_NUMBER.png and depth_color_NUMBER.png of each frame "
                          "that there is time for, "
                          "in place of the page in the browser");
  view_command.add_option("--truth", options.truth, "PFM, Z in metres: print the error against it");
  view_command.add_option("--near", options.scale.near_m, "Distance of the warmest colour, metres")
      ->check(CLI::Range(0.01, 1000.0))
      ->capture_default_str();
  view_command.add_option("--far", options.scale.far_m, "Distance of the coldest colour, metres")
      ->check(CLI::Range(0.01, 1000.0))
      ->capture_default_str();
  options.page.program = kVersion;
  add_page_flags(view_command, options.page);
  add_raw_flags(view_command, options);
  view_command.callback([&options] {
    if (!(options.scale.near_m < options.scale.far_m)) {
      throw Failure(Exit::kBadInput, "--near: is not below --far: give a smaller --near");
    }
    judge_receive_options(options);
    check_raw_flags(options);
    is_recorded(options.sensor) ? replay(options) : view(options);
  });
}

int run(int argc, char** argv) {
  CLI::App app("Receives and measures the depth of a stof sensor.", "stof");
  app.set_version_flag("--version", kVersion);
  app.require_subcommand(1);
  Commands commands;
  add_evaluate(app, commands);
  add_view(app, commands.view);
  add_proxy(app, commands.proxy);
  add_record(app, commands.record, kVersion);
  add_info(app, commands.info);
  add_recover(app, commands.recover);
  add_export(app, commands.exported);
  add_replay(app, commands.replay);
  add_bridge(app, commands.bridge);
  add_stats(app, commands.stats);
  add_health(app, commands.health);
  add_check(app, commands.check, STOF_VERSION);
  add_support_report(app, commands.report, STOF_VERSION);
  add_calib(app, commands.calib_pmd, commands.calib_install, commands.calib_rig);
  add_address(app, commands.address);
  add_config(app, commands.config);
  add_discover(app, commands.discover);
  add_fault(app, commands.fault);
  add_pair(app, commands.pair, commands.unpair);
  add_update(app, commands.update);
  add_completion(app, commands.completion);
  app.footer(kFooter);  // not one that commands inherit
  require_finite_numbers(app);
  // When the command line was understood, before any command begins.
  app.parse_complete_callback(need_output);
  judge_words(app, std::span(argv, static_cast<std::size_t>(argc)).subspan(argc > 0 ? 1 : 0));
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    throw Failure(Exit::kBadInput, std::string(error.what()) + ": try --help");
  }
  return static_cast<int>(Exit::kOk);
}

// The program's last word is one line, whatever an exception's text holds.
// Without memory: there may be none.
int complain(Exit code, const char* line) noexcept {
  std::fflush(stdout);
  std::fputs("stof: ", stderr);
  for (; *line != '\0'; ++line) {
    const bool controls = static_cast<unsigned char>(*line) < ' ' || *line == '\x7f';
    std::fputc(controls ? ' ' : *line, stderr);
  }
  std::fputc('\n', stderr);
  return static_cast<int>(code);
}

}  // namespace
}  // namespace stof::host

// What libraries ask for before main() begins: nothing there catches a refusal.
[[gnu::constructor(101)]] static void watch_memory() {
  stof::posix::end_in_one_line_when_refused("stof");
}

int main(int argc, char** argv) {
  using stof::host::Exit;
  std::set_new_handler(nullptr);  // from here on it is an exception
  // A file that may not grow any more is a full disk to us, not the end of the program.
  static_cast<void>(std::signal(SIGXFSZ, SIG_IGN));
  // Nor is a reader that has gone.
  static_cast<void>(std::signal(SIGPIPE, SIG_IGN));
  try {
    const int code = stof::host::run(argc, argv);
    // What nobody can read was not said: a full disk, a terminal that has gone.
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
      return stof::host::complain(Exit::kFailure, stof::host::unwritten_text(errno));
    }
    return code;
  } catch (const stof::host::Failure& failure) {
    return stof::host::complain(failure.code(), failure.what());
  } catch (const std::bad_alloc&) {
    return stof::host::complain(Exit::kFailure, "out of memory: use a smaller picture");
  } catch (const std::exception& error) {
    return stof::host::complain(Exit::kFailure, error.what());
  }
}
