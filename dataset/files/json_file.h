#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

#include "dataset/image.h"

// Files that hold one JSON object.
namespace stof::dataset {

// The text of such a file, of at most 1 MiB. Refused with its line and column is what is no JSON
// (nan and inf are none), and a key that an object has twice.
Loaded<std::string> read_object_text(const std::filesystem::path& file);

Loaded<nlohmann::json> read_object(const std::filesystem::path& file);

}  // namespace stof::dataset
