#include "host/picture/png.h"

#include <map>
#include <stdexcept>

#include <png.h>

#include "dataset/files/file.h"

namespace stof::host {
namespace {

struct Layout {
  int width;
  int height;
  int bit_depth;
  int colour_type;
};

// libpng reports errors by longjmp: what it jumps over has no destructors, this class keeps them.
class Writer {
 public:
  Writer()
      : png_(png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, ignore)),
        info_(png_ == nullptr ? nullptr : png_create_info_struct(png_)) {}
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;
  ~Writer() { png_destroy_write_struct(&png_, &info_); }

  // The bytes of the file; empty: libpng refused.
  std::string write(const Layout& layout, std::vector<png_bytep>& rows,
                    std::vector<png_text>& texts) {
    return info_ != nullptr && encode(layout, rows, texts) ? std::move(bytes_) : std::string();
  }

 private:
  static void ignore(png_structp /*png*/, png_const_charp /*message*/) {}
  static void append(png_structp png, png_bytep bytes, std::size_t count) {
    static_cast<std::string*>(png_get_io_ptr(png))
        ->append(reinterpret_cast<const char*>(bytes), count);
  }
  static void flush(png_structp /*png*/) {}

  bool encode(const Layout& layout, std::vector<png_bytep>& rows, std::vector<png_text>& texts) {
    if (setjmp(png_jmpbuf(png_)) != 0) {  // NOLINT: libpng's way to report an error
      return false;
    }
    png_set_write_fn(png_, &bytes_, append, flush);
    png_set_IHDR(png_, info_, static_cast<png_uint_32>(layout.width),
                 static_cast<png_uint_32>(layout.height), layout.bit_depth, layout.colour_type,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_text(png_, info_, texts.data(), static_cast<int>(texts.size()));
    png_write_info(png_, info_);
    png_write_image(png_, rows.data());
    png_write_end(png_, info_);
    return true;
  }

  std::string bytes_;
  png_structp png_;
  png_infop info_;
};

std::expected<void, dataset::Problem> write(const std::filesystem::path& file, const Layout& layout,
                                            std::vector<std::uint8_t> bytes, PngTexts texts) {
  std::vector<png_bytep> rows;
  const std::size_t row_bytes = bytes.size() / static_cast<std::size_t>(layout.height);
  for (std::size_t at = 0; at < bytes.size(); at += row_bytes) {
    rows.push_back(bytes.data() + at);
  }
  std::vector<png_text> chunks;
  for (auto& [key, text] : texts) {
    png_text chunk{};
    chunk.compression = PNG_TEXT_COMPRESSION_NONE;
    chunk.key = key.data();
    chunk.text = text.data();
    chunk.text_length = text.size();
    chunks.push_back(chunk);
  }
  const std::string png = Writer().write(layout, rows, chunks);
  if (png.empty()) {
    return dataset::refuse(file, "cannot be written as PNG", "give a smaller picture");
  }
  return dataset::write_whole(file, png);
}

// palette: red, green, blue of each index, for formats that have one.
std::string encode(int width, int height, png_uint_32 format,
                   const std::vector<std::uint8_t>& bytes,
                   const std::vector<std::uint8_t>& palette) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = format;
  image.colormap_entries = static_cast<png_uint_32>(palette.size() / 3);
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string file(size, '\0');
  if (png_image_write_to_memory(&image, file.data(), &size, 0, bytes.data(), 0,
                                palette.empty() ? nullptr : palette.data()) == 0) {
    throw std::runtime_error(std::string("a picture cannot be encoded: ") + image.message);
  }
  file.resize(size);
  return file;
}

std::vector<std::uint8_t> interleaved(const dataset::Image<Rgb>& colour) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(3 * colour.pixels.size());
  for (const Rgb& pixel : colour.pixels) {
    bytes.insert(bytes.end(), {pixel.red, pixel.green, pixel.blue});
  }
  return bytes;
}

}  // namespace

std::string png_bytes(const dataset::Image<Rgb>& colour) {
  std::map<std::uint32_t, std::uint8_t> places;
  std::vector<std::uint8_t> palette;
  std::vector<std::uint8_t> indices;
  indices.reserve(colour.pixels.size());
  for (const Rgb& pixel : colour.pixels) {
    const std::uint32_t key = std::uint32_t{pixel.red} << 16 | std::uint32_t{pixel.green} << 8 |
                              std::uint32_t{pixel.blue};
    const auto [place, is_new] =
        places.try_emplace(key, static_cast<std::uint8_t>(places.size() & 0xFF));
    if (is_new && places.size() > 256) {
      return encode(colour.width, colour.height, PNG_FORMAT_RGB, interleaved(colour), {});
    }
    if (is_new) {
      palette.insert(palette.end(), {pixel.red, pixel.green, pixel.blue});
    }
    indices.push_back(place->second);
  }
  return encode(colour.width, colour.height, PNG_FORMAT_RGB_COLORMAP, indices, palette);
}

std::string png_bytes(const dataset::Image<std::uint8_t>& grey) {
  return encode(grey.width, grey.height, PNG_FORMAT_GRAY, grey.pixels, {});
}

std::expected<void, dataset::Problem> write_png(const std::filesystem::path& file,
                                                const dataset::Image<std::uint16_t>& grey,
                                                const PngTexts& texts) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(2 * grey.pixels.size());
  for (const std::uint16_t value : grey.pixels) {  // big-endian, as PNG wants it
    bytes.push_back(static_cast<std::uint8_t>(value >> 8));
    bytes.push_back(static_cast<std::uint8_t>(value & 0xFF));
  }
  return write(file, {grey.width, grey.height, 16, PNG_COLOR_TYPE_GRAY}, std::move(bytes), texts);
}

std::expected<void, dataset::Problem> write_png(const std::filesystem::path& file,
                                                const dataset::Image<Rgb>& colour,
                                                const PngTexts& texts) {
  return write(file, {colour.width, colour.height, 8, PNG_COLOR_TYPE_RGB}, interleaved(colour),
               texts);
}

}  // namespace stof::host
