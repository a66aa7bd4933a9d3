#include "dataset/files/pfm.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

#include "dataset/files/file.h"

namespace stof::dataset {
namespace {

constexpr std::string_view kPfmRemedy = "write it as PFM \"Pf\" with a negative scale";

// Little-endian float, whatever the host.
float load(const char* bytes) {
  std::uint32_t word = 0;
  for (int i = 3; i >= 0; --i) {
    word = word << 8 | static_cast<std::uint8_t>(bytes[i]);
  }
  return std::bit_cast<float>(word);
}

void store(float value, char* bytes) {
  std::uint32_t word = std::bit_cast<std::uint32_t>(value);
  for (int i = 0; i < 4; ++i, word >>= 8) {
    bytes[i] = static_cast<char>(word & 0xFFU);
  }
}

// File row of image row y: the bottom row comes first.
std::size_t first_byte(int width, int height, int y) {
  return 4 * static_cast<std::size_t>(height - 1 - y) * static_cast<std::size_t>(width);
}

bool negative_number(std::string_view text) {
  double value = 0;
  const std::from_chars_result result =
      std::from_chars(text.data(), text.data() + text.size(), value);
  return result.ec == std::errc{} && result.ptr == text.data() + text.size() &&
         std::isfinite(value) && value < 0;
}

}  // namespace

Loaded<Image<float>> read_pfm(const std::filesystem::path& file) {
  const Loaded<std::string> bytes = read_whole(file, 4 * kMaxPixels + 1024);
  if (!bytes) {
    return std::unexpected(bytes.error());
  }
  if (!bytes->starts_with("Pf")) {
    return refuse(file, "is not a one-channel PFM picture (does not begin with Pf)", kPfmRemedy);
  }
  HeaderCursor cursor(*bytes, 2);
  const std::optional<int> width = cursor.number();
  const std::optional<int> height = cursor.number();
  if (!width || !height || *width < 1 || *height < 1 || !negative_number(cursor.word()) ||
      !cursor.separator()) {
    return refuse(file, "has a damaged header or a scale that is not negative", kPfmRemedy);
  }
  const std::size_t count = static_cast<std::size_t>(*width) * static_cast<std::size_t>(*height);
  const std::size_t found = bytes->size() - cursor.position();
  if (count > kMaxPixels || found != 4 * count) {
    return refuse(file,
                  "has the wrong length, " + size_text(*width, *height) + " pixels take " +
                      std::to_string(4 * count) + " bytes but " + std::to_string(found) +
                      " are there",
                  "copy or make it again");
  }
  Image<float> image(*width, *height);
  for (int y = 0; y < *height; ++y) {
    const char* at = bytes->data() + cursor.position() + first_byte(*width, *height, y);
    for (float& value : image.view().row(y)) {
      value = load(at);
      at += 4;
    }
  }
  return image;
}

std::expected<void, Problem> write_pfm(const std::filesystem::path& file,
                                       const Image<float>& image) {
  std::string bytes =
      "Pf\n" + std::to_string(image.width) + " " + std::to_string(image.height) + "\n-1\n";
  const std::size_t header = bytes.size();
  bytes.resize(header + 4 * image.pixels.size());
  for (int y = 0; y < image.height; ++y) {
    char* at = bytes.data() + header + first_byte(image.width, image.height, y);
    for (const float value : image.view().row(y)) {
      store(value, at);
      at += 4;
    }
  }
  return write_whole(file, bytes);
}

}  // namespace stof::dataset
