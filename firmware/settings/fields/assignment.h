#pragma once

#include <string>
#include <string_view>

#include "firmware/settings/settings.h"

// Settings on a command line. Used once, at start; allocate.
namespace stof::settings {

// "streams.depth=raw". Empty, or one line that says what is wrong; nothing is changed then.
std::string apply_assignment(Settings& settings, std::string_view assignment);

// One field per line, for --help.
std::string settings_usage();
// The documents of write_schema() and write_table(); presets in the table too.
std::string settings_schema();
std::string settings_tables();

}  // namespace stof::settings
