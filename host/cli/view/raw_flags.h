#pragma once

#include <CLI/CLI.hpp>

#include "host/cli/view/view.h"

namespace stof::host {

// The flags of `stof view` that ask for raw pictures.
void add_raw_flags(CLI::App& command, ViewOptions& options);
// After the command line was read: throws Failure where they mean nothing.
void check_raw_flags(const ViewOptions& options);

}  // namespace stof::host
