#include "firmware/settings/fields/assignment.h"

#include <array>

#include "firmware/settings/fields/describe.h"
#include "firmware/settings/fields/document.h"
#include "firmware/settings/fields/presets.h"

namespace stof::settings {
namespace {

std::string whole(void (*write)(PagedWriter&)) {
  PagedWriter count({});
  write(count);
  std::string text(count.total(), '\0');
  PagedWriter out(text);
  write(out);
  return text;
}

}  // namespace

std::string apply_assignment(Settings& settings, std::string_view assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string_view::npos) {
    return "\"" + std::string(assignment) + "\": write SETTING=VALUE, such as streams.depth=raw";
  }
  std::array<char, kWhyBytes> space;
  PagedWriter why(space);
  const bool done =
      parse_field(assignment.substr(0, equals), assignment.substr(equals + 1), settings, why);
  return done ? std::string() : std::string(why.text());
}

std::string settings_usage() { return whole(&write_usage); }

std::string settings_schema() { return whole(&write_schema); }

std::string settings_tables() {
  return whole([](PagedWriter& out) {
    write_table(out);
    out << '\n';
    write_preset_table(out);
  });
}

}  // namespace stof::settings
