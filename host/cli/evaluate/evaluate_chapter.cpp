#include "host/cli/evaluate/evaluate_chapter.h"

#include "host/cli/failure.h"
#include "host/cli/help_text.h"
#include "host/cli/output.h"

namespace stof::host {
namespace {

void evaluate_chapter(const ReportOptions& options) {
  ReportOptions asked = options;
  if (asked.quick) {
    asked.runs = 1;
  }
  asked.begins = [](const char* part) { say(std::string("measuring     ") + part); };
  const ReportResult result = value_or_fail(write_report(asked));
  say_text(result.summary);
  for (const std::string& name : result.refused) {
    say("left out      this matcher does not run: " + name);
  }
  say(options.out.string());
}

}  // namespace

void add_evaluate_chapter(CLI::App& evaluate, ReportOptions& options) {
  CLI::App& command = *evaluate.add_subcommand(
      "chapter", "Repeat the book chapter's stereo experiments; one self-contained HTML page");
  show_example(command, "stof evaluate chapter stereo/Cones stereo/Teddy --out chapter.html",
               kFilesEnds);
  command.add_option("DIR", options.scenes, "Folders with left.pgm, right.pgm, meta.txt")
      ->required();
  command.add_option("--corridor", options.corridor,
                     "A folder of that kind whose meta.txt knows its rig: adds its depth");
  command.add_option("--out", options.out, "The page")->required();
  command.add_option("--runs", options.runs, "Runs of which the median time is shown")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command.add_flag("--plain", options.plain, "Adds times of the methods without vector kernels");
  command.add_flag("--quick", options.quick, "One run and small views, to see that it works");
  command.callback([&options] { evaluate_chapter(options); });
}

}  // namespace stof::host
