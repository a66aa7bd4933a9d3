#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace stof::host {

inline constexpr const char* kUsualEnds =
    "Ends with 0 (done), 1 (nothing or less than asked for was received, or the output cannot be "
    "written) or 2 (bad input: one line says what).";

// Of commands that ask no sensor.
inline constexpr const char* kFilesEnds =
    "Ends with 0 (done), 1 (the output cannot be written) or 2 (bad input: one line says what).";

// What follows the flags in a command's help: how it is called, and the exit codes. example: the
// whole line; more of them follow in lines of their own.
inline void show_example(CLI::App& command, const std::string& example,
                         const std::string& ends = kUsualEnds) {
  command.footer("Example: " + example + "\n" + ends);
}

// Of a SENSOR: a text that a script left empty means none.
inline CLI::Validator not_empty() {
  return {[](const std::string& text) {
            return text.empty() ? std::string("is empty: name a sensor") : std::string();
          },
          ""};
}

// SENSOR of commands that only read.
inline constexpr const char* kSensorOrFile =
    "Serial number, name or HOST[:PORT] of a sensor, port 7560 without, or a file that stof record "
    "wrote";
inline constexpr const char* kSensorOnly =
    "Serial number, name or HOST[:PORT] of the sensor, port 7560 without";

}  // namespace stof::host
