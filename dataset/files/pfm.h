#pragma once

#include <expected>
#include <filesystem>

#include "dataset/image.h"

namespace stof::dataset {

// PFM, "Pf", bottom row first, scale -1 (little-endian); +inf = none.
Loaded<Image<float>> read_pfm(const std::filesystem::path& file);
std::expected<void, Problem> write_pfm(const std::filesystem::path& file,
                                       const Image<float>& image);

}  // namespace stof::dataset
