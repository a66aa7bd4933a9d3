#include "host/cli/json_output.h"

#include <cmath>

#include "host/cli/output.h"

namespace stof::host {

namespace {

std::string replaced_text(const nlohmann::ordered_json& json, int indent) {
  return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace

void add_json_flag(CLI::App& command, bool& json) {
  command.add_flag("--json", json, "A JSON object, and nothing else");
}

nlohmann::ordered_json number_or_null(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

std::string json_text(const nlohmann::ordered_json& json) { return replaced_text(json, 2); }

void say_json(const nlohmann::ordered_json& json) { say(json_text(json)); }
void say_json_line(const nlohmann::ordered_json& json) { say(replaced_text(json, -1)); }

}  // namespace stof::host
