#include "host/cli/evaluate/evaluate_pmd.h"

#include <cstdio>

#include "host/cli/failure.h"
#include "host/cli/help_text.h"
#include "host/evaluate/pmd/figures.h"
#include "host/evaluate/pmd/print/json.h"
#include "host/evaluate/pmd/print/text.h"
#include "host/report/pmd/pmd_page.h"

namespace stof::host {
void evaluate_pmd(const EvaluatePmdOptions& options) {
  const PmdOptions asked{.folder = options.folder,
                         .calibration = options.calibration,
                         .fitted = frames_named(options.frames)};
  const PmdEvaluation evaluation = value_or_fail(evaluate_pmd(asked));
  if (!options.html.empty()) {
    value_or_fail(write_pmd_page(evaluation, options.html));
  }
  std::printf("%s",
              options.json ? (pmd_json(evaluation) + "\n").c_str() : pmd_text(evaluation).c_str());
}

void add_evaluate_pmd(CLI::App& evaluate, EvaluatePmdOptions& options) {
  CLI::App& command = *evaluate.add_subcommand(
      "pmd", "PMD recordings: walls, edges, lights, stray light, two frequencies, camera frames");
  show_example(command, "stof evaluate pmd tof/sim --html pmd.html", kFilesEnds);
  command
      .add_option("DIR", options.folder,
                  "Folder of recordings (PREFIX.json, PREFIX_raw.pgm), or of such folders")
      ->required();
  command.add_option("--calibration", options.calibration,
                     "Calibration file in place of what walls and recordings say");
  command
      .add_option("--frames", options.frames,
                  "Frames that walls are calibrated on; the others judge")
      ->check(CLI::IsMember(kFramesNames))
      ->capture_default_str();
  command.add_flag("--json", options.json, "Machine-readable result on stdout");
  command.add_option("--html", options.html, "A self-contained page with pictures");
  command.callback([&options] { evaluate_pmd(options); });
}

}  // namespace stof::host
