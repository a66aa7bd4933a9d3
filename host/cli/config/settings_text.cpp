#include "host/cli/config/settings_text.h"

#include <algorithm>
#include <utility>

#include "dataset/files/json_file.h"
#include "host/cli/failure.h"

namespace stof::host {
namespace {

using Leaves = std::vector<std::pair<std::string, Json>>;

void collect(const Json& node, const std::string& path, Leaves& leaves) {
  if (!node.is_object()) {
    leaves.emplace_back(path, node);
    return;
  }
  for (const auto& [name, member] : node.items()) {
    std::string longer = path;
    longer.append(path.empty() ? "" : ".").append(name);
    collect(member, longer, leaves);
  }
}

// Puts a value where the path says; groups on the way appear. Throws Failure where a name is that
// of a value and of a group.
void put(Json& document, std::string_view whole, Json value) {
  Json* node = &document;
  std::string_view path = whole;
  const auto both = [whole](std::string_view name) {
    return Failure(Exit::kBadInput, std::string(whole) + ": \"" + std::string(name) +
                                        "\" is given as a value and as a group of settings");
  };
  while (true) {
    const std::size_t dot = path.find('.');
    const std::string name(path.substr(0, dot));
    if (name.empty()) {
      throw Failure(Exit::kBadInput, "\"" + std::string(whole) + "\": a setting's name is missing");
    }
    const bool known = node->contains(name);
    node = &(*node)[name];
    if (dot == std::string_view::npos) {
      if (known && node->is_object()) {
        throw both(name);
      }
      *node = std::move(value);
      return;
    }
    if (!known) {
      *node = Json::object();
    } else if (!node->is_object()) {
      throw both(name);
    }
    path.remove_prefix(dot + 1);
  }
}

// JSON where it reads as a number, a boolean or a string of JSON, else text.
Json value_of(const std::string& text) {
  const std::optional<Json> value = read_json(text);
  const bool scalar = value && (value->is_number() || value->is_boolean() || value->is_string());
  return scalar ? *value : Json(text);
}

Json read_document(const std::string& name) {
  const dataset::Loaded<std::string> text = dataset::read_object_text(name);
  if (!text) {
    throw Failure(Exit::kBadInput, text.error().message + "; or give PATH=VALUE");
  }
  std::optional<Json> document = read_json(*text);
  if (!document) {
    throw Failure(Exit::kBadInput, name + ": is nested deeper than any settings are");
  }
  return *std::move(document);
}

std::string dump(const Json& document) {
  // What is no UTF-8 is for the sensor to refuse.
  return document.dump(-1, ' ', false, Json::error_handler_t::ignore);
}

}  // namespace

std::optional<Json> read_json(std::string_view text) {
  // Whoever walks through a document calls itself for each level.
  constexpr int kDeepest = 16;
  int depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      i += c == '\\' ? 1 : 0;
      in_string = c != '"';
    } else if (c == '"') {
      in_string = true;
    } else if (c == '{' || c == '[') {
      if (++depth > kDeepest) {
        return std::nullopt;
      }
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  Json parsed = Json::parse(text, nullptr, false);
  return parsed.is_discarded() ? std::nullopt : std::optional(std::move(parsed));
}

std::string name_in_settings(const Json& document) {
  const Json name = document.is_object() ? document.value("name", Json()) : Json();
  return name.is_string() ? name.get<std::string>() : "";
}

Json settings_from_words(std::span<const std::string> words) {
  if (words.empty()) {
    throw Failure(Exit::kBadInput, "nothing to change: give PATH=VALUE, or a file of settings");
  }
  Json document = Json::object();
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    if (equals == std::string::npos) {
      Leaves leaves;
      collect(read_document(word), "", leaves);
      for (auto& [path, value] : leaves) {
        put(document, path, std::move(value));
      }
    } else {
      put(document, std::string_view(word).substr(0, equals), value_of(word.substr(equals + 1)));
    }
  }
  return document;
}

std::vector<std::string> settings_pieces(const Json& document, std::size_t most) {
  Leaves leaves;
  collect(document, "", leaves);
  std::vector<std::string> pieces;
  Json piece = Json::object();
  for (const auto& [path, value] : leaves) {
    Json longer = piece;
    put(longer, path, value);
    if (dump(longer).size() > most && !piece.empty()) {
      pieces.push_back(dump(piece));
      longer = Json::object();
      put(longer, path, value);
    }
    if (dump(longer).size() > most) {
      throw Failure(Exit::kBadInput, path + ": too long for any setting");
    }
    piece = std::move(longer);
  }
  pieces.push_back(dump(piece));
  return pieces;
}

Json settings_at(const Json& document, std::string_view path) {
  const Json* node = &document;
  std::string_view left = path;
  while (!left.empty()) {
    const std::size_t dot = std::min(left.find('.'), left.size());
    const std::string name(left.substr(0, dot));
    if (!node->is_object() || !node->contains(name)) {
      throw Failure(Exit::kBadInput,
                    std::string(path) + ": this sensor has no such setting: try get alone");
    }
    node = &(*node)[name];
    left.remove_prefix(std::min(dot + 1, left.size()));
  }
  return *node;
}

std::vector<SettingsChange> settings_diff(const Json& document, const Json& other) {
  Leaves leaves;
  Leaves others;
  collect(document, "", leaves);
  collect(other, "", others);
  std::vector<SettingsChange> changes;
  for (auto& [path, value] : leaves) {
    const auto same_path = [&path](const auto& leaf) { return leaf.first == path; };
    const auto found = std::ranges::find_if(others, same_path);
    Json before = found == others.end() ? Json() : found->second;
    if (value != before) {
      changes.push_back({.path = path, .value = value, .before = std::move(before)});
    }
  }
  return changes;
}

std::string settings_value(const Json& value) {
  return value.is_string() ? value.get<std::string>() : value.dump();
}

}  // namespace stof::host
