#include "host/cli/finite_numbers.h"

#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <string>

namespace stof::host {
namespace {

// What is no number at all is refused by the conversion.
std::string problem_of_number(const std::string& text) {
  return std::isfinite(std::strtod(text.c_str(), nullptr)) ? "" : "takes a number, not " + text;
}

// CLI11 reads by strtoull, which makes 18446744073709551611 of -5, and the largest of what is more.
std::string problem_of_count(const std::string& text) {
  errno = 0;
  static_cast<void>(std::strtoull(text.c_str(), nullptr, 0));
  return text.contains('-') || errno == ERANGE ? "takes a whole number from 0 on, not " + text : "";
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
