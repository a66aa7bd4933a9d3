#pragma once

#include <CLI/CLI.hpp>

#include "host/report/report.h"

namespace stof::host {

// Adds `stof evaluate chapter`: writes the page, prints its path and the verdicts.
void add_evaluate_chapter(CLI::App& evaluate, ReportOptions& options);

}  // namespace stof::host
