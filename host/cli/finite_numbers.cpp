#include "host/cli/finite_numbers.h"

#include <cmath>
#include <cstdlib>
#include <string>

namespace stof::host {
namespace {

// What is no number at all is refused by the conversion.
std::string problem_of_number(const std::string& text) {
  return std::isfinite(std::strtod(text.c_str(), nullptr)) ? "" : "takes a number, not " + text;
}

std::string problem_of_count(const std::string& text) {
  return text.starts_with('-') ? "takes a number that is not negative, not " + text : "";
}

}  // namespace

void require_finite_numbers(CLI::App& command) {
  for (CLI::Option* const option : command.get_options([](CLI::Option*) { return true; })) {
    if (option->get_type_name().starts_with("FLOAT")) {
      option->check(problem_of_number);
    } else if (option->get_type_name().starts_with("UINT")) {
      option->check(problem_of_count);
    }
  }
  for (CLI::App* const below : command.get_subcommands([](CLI::App*) { return true; })) {
    require_finite_numbers(*below);
  }
}

}  // namespace stof::host
