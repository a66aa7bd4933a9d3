#pragma once

#include <CLI/CLI.hpp>

namespace stof::host {

// Every option of the command and of its subcommands that takes a real number refuses nan and inf,
// which the ranges of CLI11 let pass, and every one that takes a whole number from 0 on refuses
// what lies below 0 or beyond 64 bits. For options that are there by now.
void require_finite_numbers(CLI::App& command);

}  // namespace stof::host
