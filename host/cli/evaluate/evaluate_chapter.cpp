#include "host/cli/report.h"

#include <cstdio>

#include "host/cli/failure.h"

namespace stof::host {

void add_report_flags(CLI::App& command, ReportOptions& options) {
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
}

void report(const ReportOptions& options) {
  ReportOptions asked = options;
  if (asked.quick) {
    asked.runs = 1;
  }
  asked.begins = [](const char* part) {
    std::printf("measuring     %s\n", part);
    std::fflush(stdout);
  };
  const ReportResult result = value_or_fail(write_report(asked));
  std::printf("%s", result.summary.c_str());
  for (const std::string& name : result.refused) {
    std::printf("left out      this matcher does not run: %s\n", name.c_str());
  }
  std::printf("%s\n", options.out.c_str());
}

}  // namespace stof::host
