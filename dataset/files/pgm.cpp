#include "dataset/files/pgm.h"

#include <cstring>

#include "dataset/files/file.h"

namespace stof::dataset {
namespace {

constexpr std::size_t kMaxHeader = 65536;  // room for comments
constexpr std::string_view kPgmRemedy = "convert it to binary PGM (P5)";

// A file whose header is understood and whose pixel bytes are all there.
struct Raw {
  std::string bytes;
  std::size_t pixels_at = 0;
  int width = 0;
  int height = 0;
  int maxval = 0;

  std::size_t count() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
  std::uint8_t byte(std::size_t i) const { return static_cast<std::uint8_t>(bytes[pixels_at + i]); }
};

Loaded<Raw> read_raw(const std::filesystem::path& file) {
  Loaded<std::string> bytes = read_whole(file, 2 * kMaxPixels + kMaxHeader);
  if (!bytes) {
    return std::unexpected(std::move(bytes.error()));
  }
  if (!bytes->starts_with("P5")) {
    return refuse(file, "is not a binary PGM picture (does not begin with P5)", kPgmRemedy);
  }
  HeaderCursor cursor(*bytes, 2);
  const std::optional<int> width = cursor.number();
  const std::optional<int> height = cursor.number();
  const std::optional<int> maxval = cursor.number();
  if (!width || !height || !maxval || !cursor.separator()) {
    return refuse(file, "has a damaged header", kPgmRemedy);
  }
  if (*width < 1 || *height < 1 || *maxval < 1 || *maxval > 65535) {
    return refuse(file,
                  "has the impossible size or maxval " + size_text(*width, *height) + ", " +
                      std::to_string(*maxval),
                  kPgmRemedy);
  }
  Raw raw{.bytes = {},
          .pixels_at = cursor.position(),
          .width = *width,
          .height = *height,
          .maxval = *maxval};
  if (raw.count() > kMaxPixels) {
    return refuse(file, "has " + size_text(*width, *height) + " pixels, more than 67108864",
                  "use a smaller picture");
  }
  const std::size_t expected = raw.count() * (*maxval > 255 ? 2 : 1);
  const std::size_t found = bytes->size() - raw.pixels_at;
  if (found != expected) {
    return refuse(file,
                  std::string(found < expected ? "is truncated" : "is too long") + ", " +
                      size_text(*width, *height) + " pixels take " + std::to_string(expected) +
                      " bytes but " + std::to_string(found) + " are there",
                  "copy or make it again");
  }
  raw.bytes = std::move(*bytes);
  return raw;
}

std::unexpected<Problem> above_maxval(const std::filesystem::path& file, int sample, int maxval) {
  return refuse(
      file,
      "holds the sample " + std::to_string(sample) + " above its maxval " + std::to_string(maxval),
      "make it again");
}

template <typename T>
std::string pgm_header(const Image<T>& image, int maxval) {
  return "P5\n" + std::to_string(image.width) + " " + std::to_string(image.height) + "\n" +
         std::to_string(maxval) + "\n";
}

}  // namespace

Loaded<Image<std::uint8_t>> read_pgm8(const std::filesystem::path& file) {
  const Loaded<Raw> raw = read_raw(file);
  if (!raw) {
    return std::unexpected(raw.error());
  }
  if (raw->maxval > 255) {
    return refuse(file,
                  "has 16-bit samples (maxval " + std::to_string(raw->maxval) + "), 8 bit expected",
                  "convert it to maxval 255");
  }
  Image<std::uint8_t> image(raw->width, raw->height);
  std::memcpy(image.pixels.data(), raw->bytes.data() + raw->pixels_at, image.pixels.size());
  for (const std::uint8_t sample : image.pixels) {
    if (sample > raw->maxval) {
      return above_maxval(file, sample, raw->maxval);
    }
  }
  return image;
}

Loaded<Image<std::uint16_t>> read_pgm16(const std::filesystem::path& file) {
  const Loaded<Raw> raw = read_raw(file);
  if (!raw) {
    return std::unexpected(raw.error());
  }
  Image<std::uint16_t> image(raw->width, raw->height);
  const bool wide = raw->maxval > 255;
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const int sample = wide ? raw->byte(2 * i) * 256 + raw->byte(2 * i + 1) : raw->byte(i);
    if (sample > raw->maxval) {
      return above_maxval(file, sample, raw->maxval);
    }
    image.pixels[i] = static_cast<std::uint16_t>(sample);
  }
  return image;
}

std::string pgm_bytes(const Image<std::uint8_t>& image) {
  std::string bytes = pgm_header(image, 255);
  for (const std::uint8_t value : image.pixels) {
    bytes.push_back(static_cast<char>(value));
  }
  return bytes;
}

// Big-endian, as PGM requires.
std::string pgm_bytes(const Image<std::uint16_t>& image) {
  std::string bytes = pgm_header(image, 65535);
  for (const std::uint16_t value : image.pixels) {
    bytes.push_back(static_cast<char>(value >> 8U));
    bytes.push_back(static_cast<char>(value & 0xFFU));
  }
  return bytes;
}

std::expected<void, Problem> write_pgm8(const std::filesystem::path& file,
                                        const Image<std::uint8_t>& image) {
  return write_whole(file, pgm_bytes(image));
}

std::expected<void, Problem> write_pgm16(const std::filesystem::path& file,
                                         const Image<std::uint16_t>& image) {
  return write_whole(file, pgm_bytes(image));
}

}  // namespace stof::dataset
