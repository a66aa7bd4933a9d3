#include "host/picture/png.h"

#include <cstdio>
#include <map>
#include <stdexcept>

#include <fcntl.h>
#include <png.h>
#include <sys/stat.h>
#include <unistd.h>

namespace stof::host {
namespace {

struct Layout {
  int width;
  int height;
  int bit_depth;
  int colour_type;
};

// Follows no link, and waits for nobody at a pipe: a folder that others write to may hold either.
std::FILE* open_file(const std::filesystem::path& file) {
  constexpr mode_t kMode = 0666;  // less the umask
  const int fd = ::open(file.c_str(),
                        O_WRONLY | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC, kMode);
  if (fd < 0) {
    return nullptr;
  }
  struct stat is{};
  const bool usable = ::fstat(fd, &is) == 0 &&
                      (S_ISCHR(is.st_mode) || (S_ISREG(is.st_mode) && ::ftruncate(fd, 0) == 0));
  std::FILE* const stream = usable ? ::fdopen(fd, "wb") : nullptr;
  if (stream == nullptr) {
    ::close(fd);
  }
  return stream;
}

// libpng reports errors by longjmp: what it jumps over has no destructors, this class keeps them.
class Writer {
 public:
  explicit Writer(const std::filesystem::path& file)
      : stream_(open_file(file)),
        png_(png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, ignore)),
        info_(png_ == nullptr ? nullptr : png_create_info_struct(png_)) {}
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;
  ~Writer() {
    png_destroy_write_struct(&png_, &info_);
    if (stream_ != nullptr) {
      std::fclose(stream_);
    }
  }

  bool write(const Layout& layout, std::vector<png_bytep>& rows, std::vector<png_text>& texts) {
    if (stream_ == nullptr || info_ == nullptr || !encode(layout, rows, texts)) {
      return false;
    }
    return std::fclose(std::exchange(stream_, nullptr)) == 0;
  }

 private:
  static void ignore(png_structp /*png*/, png_const_charp /*message*/) {}

  bool encode(const Layout& layout, std::vector<png_bytep>& rows, std::vector<png_text>& texts) {
    if (setjmp(png_jmpbuf(png_)) != 0) {  // NOLINT: libpng's way to report an error
      return false;
    }
    png_init_io(png_, stream_);
    png_set_IHDR(png_, info_, static_cast<png_uint_32>(layout.width),
                 static_cast<png_uint_32>(layout.height), layout.bit_depth, layout.colour_type,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_text(png_, info_, texts.data(), static_cast<int>(texts.size()));
    png_write_info(png_, info_);
    png_write_image(png_, rows.data());
    png_write_end(png_, info_);
    return true;
  }

  std::FILE* stream_;
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
  if (!Writer(file).write(layout, rows, chunks)) {
    return std::unexpected(dataset::Problem{file.string() +
                                            ": cannot be written: check the folder, its "
                                            "permissions and the free space; a link or a pipe "
                                            "of that name is not written to"});
  }
  return {};
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
