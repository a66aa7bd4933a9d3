#include "host/cli/evaluate/evaluate_fusion.h"

#include <cmath>
#include <cstdio>
#include <set>

#include "dsp/depth/max_range.h"
#include "host/calibrate/calibration_store.h"
#include "host/cli/evaluate/fusion_print.h"
#include "host/cli/failure.h"
#include "host/evaluate/fusion/fusion_case.h"
#include "host/report/fusion/fusion_page.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

void write_maps(const DepthPlanes& planes, const std::filesystem::path& folder) {
  make_folder(folder);
  value_or_fail(dataset::write_pfm(folder / "depth.pfm", planes.depth));
  value_or_fail(dataset::write_pfm(folder / "lo.pfm", planes.low));
  value_or_fail(dataset::write_pfm(folder / "hi.pfm", planes.high));
}

void refuse_what_means_nothing(const EvaluateFusionOptions& options) {
  if (options.pairs.size() % 2 != 0) {
    throw Failure(Exit::kBadInput, options.pairs.back().string() +
                                       ": has no PREFIX behind it: give STEREO_DIR and PREFIX of "
                                       "each pair in turn");
  }
  if (options.guided && options.chapter_geometry) {
    throw Failure(Exit::kBadInput,
                  "--chapter-geometry, --guided: the chapter's search has no guide: choose one");
  }
  value_or_fail(fusion_params(options.match, 1));
  std::set<std::filesystem::path> names;
  for (std::size_t i = 1; i < options.pairs.size() && !options.out.empty(); i += 2) {
    if (!names.insert(options.pairs[i].filename()).second) {
      throw Failure(Exit::kBadInput, options.pairs[i].string() +
                                         ": a second recording of this name: its maps would "
                                         "overwrite the first one's");
    }
  }
}

// Each once, beside the result.
void print_notes(std::span<const FusionCase> cases) {
  std::set<std::string> notes;
  for (const FusionCase& fused : cases) {
    if (!fused.note.empty() && notes.insert(fused.note).second) {
      std::fprintf(stderr, "stof: note: %s\n", fused.note.c_str());
    }
  }
}

FusionOptions fusion_options(const EvaluateFusionOptions& options) {
  FusionOptions result;
  if (options.max_range_m) {
    result.max_range =
        static_cast<dsp::QuarterMm>(std::lround(*options.max_range_m * dsp::kQuarterMmPerMetre));
  }
  if (!options.truth_m.empty()) {
    result.truth = {.nearest = options.truth_m[0], .farthest = options.truth_m[1]};
  }
  result.guided = options.guided;
  result.chapter_geometry = options.chapter_geometry;
  result.runs = options.match.runs;
  result.threads = options.match.threads;
  return result;
}

}  // namespace

void add_fusion_flags(CLI::App& command, EvaluateFusionOptions& options) {
  command
      .add_option("STEREO_DIR_PREFIX", options.pairs,
                  "Folder of a stereo pair and its PMD recording (PREFIX.json, PREFIX_raw.pgm); "
                  "several pairs in turn")
      ->required()
      ->type_name("STEREO_DIR PREFIX");
  command
      .add_option("--max-range", options.max_range_m,
                  "Metres beyond which nothing is measured (default: the appliance's)")
      ->check(CLI::Range(dsp::kLeastMaxRangeMm / kMm, dsp::kMostMaxRangeMm / kMm));
  command
      .add_option("--truth", options.truth_m,
                  "Judges only pixels whose true depth lies between NEAR and FAR metres")
      ->expected(2)
      ->type_name("NEAR FAR")
      ->check(CLI::NonNegativeNumber);
  command.add_option("--calibration", options.calibration,
                     "What stof calib pmd found of the PMD camera, in place of its json");
  command.add_flag("--guided", options.guided, "PMD intervals narrow the search");
  command.add_flag("--chapter-geometry", options.chapter_geometry,
                   "Adds the chapter's fusion of a scaled PMD map, for comparison");
  command.add_option("--html", options.html, "A page with all maps and tables");
  add_evaluate_flags(command, options, Judged::kDepth);
  add_out_flag(command, options);
  add_runs_flag(command, options);
}

void evaluate_fusion(const EvaluateFusionOptions& options) {
  refuse_what_means_nothing(options);
  FusionOptions how = fusion_options(options);
  StoredCalibration stored;
  if (!options.calibration.empty()) {
    stored = value_or_fail(read_pmd_calibration(options.calibration));
    how.camera = stored.calibration.pmd;
  }
  std::vector<FusionCase> cases;
  for (std::size_t i = 0; i < options.pairs.size(); i += 2) {
    cases.push_back(
        value_or_fail(run_fusion_case(options.pairs[i], options.pairs[i + 1], options.match, how)));
  }
  print_notes(cases);
  const bool several = cases.size() > 1;
  for (const FusionCase& fused : cases) {
    if (!options.out.empty()) {
      write_maps(fused.result.fused, options.out / fused.recording);
    }
  }
  if (!options.html.empty()) {
    value_or_fail(write_fusion_page(cases, describe(options.match), options.html));
  }
  if (several && options.json) {
    print_fusion_json(cases, options.match);
  } else if (several) {
    print_fusion_text(cases, options.match);
  } else if (options.json) {
    print_fusion_json(cases.front(), options.match);
  } else {
    print_fusion_text(cases.front(), options.match);
  }
}

}  // namespace stof::host
