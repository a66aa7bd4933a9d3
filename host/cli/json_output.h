#pragma once

#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

// How commands print JSON, one rule for all: what is asked once, or has an end, is one document at
// its end; what goes on is one object a line. stdout holds nothing else: questions, and what a long
// work says meanwhile, go to stderr. Whoever did nothing prints nothing.
namespace stof::host {

// --json: one object at the end.
void add_json_flag(CLI::App& command, bool& json);

// A number that is none (NaN, infinite) is null.
nlohmann::ordered_json number_or_null(double value);

// Bytes that are no UTF-8 are replaced: texts come from the network and may be anything.
std::string json_text(const nlohmann::ordered_json& json);
// One document, indented. Throws Failure as say() does.
void say_json(const nlohmann::ordered_json& json);
// One of several, on a line.
void say_json_line(const nlohmann::ordered_json& json);

}  // namespace stof::host
