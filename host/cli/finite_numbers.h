#pragma once

#include <CLI/CLI.hpp>

namespace stof::host {

// Every option of the command and of its subcommands that takes a real number refuses nan and inf,
// which the ranges of CLI11 let pass; every one that takes a count a minus, which CLI11 takes for a
// number near 2^64. For options that are there by now.
void require_finite_numbers(CLI::App& command);

}  // namespace stof::host
