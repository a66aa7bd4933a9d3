#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

// Settings as people write and read them. No knowledge of single fields: what they take, the sensor
// says.
namespace stof::host {

using Json = nlohmann::ordered_json;

// The document of a text from anywhere. None: it is not JSON, or nested deeper than any settings
// are.
std::optional<Json> read_json(std::string_view text);

// What a document calls the sensor, any text; empty: it does not.
std::string name_in_settings(const Json& document);

// {"streams.depth=raw", "depth.match.lr=2", "rig.json"} as one document; what comes later changes
// what came before. A word without "=" is the name of a file. Throws Failure.
Json settings_from_words(std::span<const std::string> words);

// The same document as texts of at most `most` bytes, each a document itself that holds some of the
// leaves. Throws Failure where one leaf alone is longer.
std::vector<std::string> settings_pieces(const Json& document, std::size_t most);

// The settings that the path names, "depth.match", or all where it is empty. Throws Failure.
Json settings_at(const Json& document, std::string_view path);

struct SettingsChange {
  std::string path;
  Json value;
  Json before;
};
// The leaves of `document` that differ from `other`; before is null where `other` has none.
std::vector<SettingsChange> settings_diff(const Json& document, const Json& other);

// A string bare, everything else as JSON.
std::string settings_value(const Json& value);

}  // namespace stof::host
