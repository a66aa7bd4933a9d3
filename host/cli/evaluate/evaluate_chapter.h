#pragma once

#include <CLI/CLI.hpp>

#include "host/report/report.h"

namespace stof::host {

// Adds the flags of `stof report`.
void add_report_flags(CLI::App& command, ReportOptions& options);

// Writes the page, prints its path and the verdicts. Throws Failure.
void report(const ReportOptions& options);

}  // namespace stof::host
