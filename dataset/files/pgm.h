#pragma once

#include <cstdint>
#include <expected>
#include <filesystem>
#include <string>

#include "dataset/image.h"

namespace stof::dataset {

// Binary PGM (P5), 8 bit (maxval <= 255) or 16 bit big-endian. Refused: other formats, truncated or
// oversized (more than 2^26 pixels) files, samples above maxval.
Loaded<Image<std::uint8_t>> read_pgm8(const std::filesystem::path& file);
Loaded<Image<std::uint16_t>> read_pgm16(const std::filesystem::path& file);

std::expected<void, Problem> write_pgm8(const std::filesystem::path& file,
                                        const Image<std::uint8_t>& image);
std::expected<void, Problem> write_pgm16(const std::filesystem::path& file,
                                         const Image<std::uint16_t>& image);

// The bytes of such a file.
std::string pgm_bytes(const Image<std::uint8_t>& image);
std::string pgm_bytes(const Image<std::uint16_t>& image);

}  // namespace stof::dataset
