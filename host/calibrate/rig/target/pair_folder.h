#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dataset/dataset.h"

namespace stof::host {

// The two pictures of one exposure, 8 bit grey.
struct Pair {
  std::string name;
  dataset::Image<std::uint8_t> left;
  dataset::Image<std::uint8_t> right;
};

// The folders in DIR that hold left.pgm and right.pgm, by name. One line where there is none, or
// one has one of them alone.
dataset::Loaded<std::vector<std::filesystem::path>> list_pairs(const std::filesystem::path& dir);
// The same of a folder that may hold none yet.
dataset::Loaded<std::vector<std::filesystem::path>> pairs_so_far(const std::filesystem::path& dir);

// One line where a picture is missing or broken, or the two differ in size.
dataset::Loaded<Pair> read_pair(const std::filesystem::path& dir);

}  // namespace stof::host
