#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "dataset/dataset.h"

namespace stof::host {

struct Rgb {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;
  friend bool operator==(const Rgb&, const Rgb&) = default;
};

// Keyword and Latin-1 text of a tEXt chunk; a keyword has 1 to 79 characters.
using PngTexts = std::vector<std::pair<std::string, std::string>>;

// Write one picture of at least one pixel; an older file of that name is replaced. One line when
// that fails.
std::expected<void, dataset::Problem> write_png(const std::filesystem::path& file,
                                                const dataset::Image<std::uint16_t>& grey,
                                                const PngTexts& texts);
std::expected<void, dataset::Problem> write_png(const std::filesystem::path& file,
                                                const dataset::Image<Rgb>& colour,
                                                const PngTexts& texts);

// The bytes of a PNG file of one picture of at least one pixel, 8 bit a channel; with a palette
// where 256 colours are enough.
std::string png_bytes(const dataset::Image<Rgb>& colour);
std::string png_bytes(const dataset::Image<std::uint8_t>& grey);

}  // namespace stof::host
