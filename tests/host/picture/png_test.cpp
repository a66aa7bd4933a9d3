#include "host/picture/png.h"

#include <algorithm>
#include <cstdio>
#include <map>

#include <gtest/gtest.h>
#include <png.h>
#include <sys/stat.h>

#include "tests/dataset/scratch.h"

namespace stof::host {
namespace {

// What libpng reads back.
struct ReadBack {
  png_uint_32 width = 0;
  png_uint_32 height = 0;
  int bit_depth = 0;
  int colour_type = 0;
  std::vector<std::uint8_t> bytes;
  std::map<std::string, std::string> texts;
};

ReadBack read_back(const std::filesystem::path& file) {
  ReadBack result;
  std::FILE* const stream = std::fopen(file.c_str(), "rb");
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, stream);  // an error aborts the test program
  png_read_png(png, info, PNG_TRANSFORM_IDENTITY, nullptr);
  int interlace = 0;
  png_get_IHDR(png, info, &result.width, &result.height, &result.bit_depth, &result.colour_type,
               &interlace, nullptr, nullptr);
  png_bytepp rows = png_get_rows(png, info);
  for (png_uint_32 y = 0; y < result.height; ++y) {
    result.bytes.insert(result.bytes.end(), rows[y], rows[y] + png_get_rowbytes(png, info));
  }
  png_textp texts = nullptr;
  int count = 0;
  png_get_text(png, info, &texts, &count);
  for (int i = 0; i < count; ++i) {
    result.texts[texts[i].key] = texts[i].text;
  }
  png_destroy_read_struct(&png, &info, nullptr);
  std::fclose(stream);
  return result;
}

class Png : public test::Scratch {};

TEST_F(Png, HoldsEverySixteenBitValue) {
  dataset::Image<std::uint16_t> grey(256, 256);
  std::ranges::generate(grey.pixels, [value = std::uint16_t{0}]() mutable { return value++; });
  ASSERT_TRUE(write_png(folder() / "a.png", grey, {{"Description", "unit 0.25 mm"}}));
  const ReadBack back = read_back(folder() / "a.png");
  EXPECT_EQ(back.width, 256U);
  EXPECT_EQ(back.height, 256U);
  EXPECT_EQ(back.bit_depth, 16);
  EXPECT_EQ(back.colour_type, PNG_COLOR_TYPE_GRAY);
  EXPECT_EQ(back.texts.at("Description"), "unit 0.25 mm");
  ASSERT_EQ(back.bytes.size(), 2 * 65536U);
  for (std::size_t i = 0; i < 65536; ++i) {
    ASSERT_EQ(back.bytes[2 * i] * 256U + back.bytes[2 * i + 1], i);
  }
}

TEST_F(Png, HoldsColoursRowByRow) {
  dataset::Image<Rgb> colour(2, 3);
  for (std::size_t i = 0; i < 6; ++i) {
    const std::uint8_t base = static_cast<std::uint8_t>(40 * i);
    colour.pixels[i] = {base, static_cast<std::uint8_t>(base + 1),
                        static_cast<std::uint8_t>(base + 2)};
  }
  ASSERT_TRUE(write_png(folder() / "a.png", colour, {}));
  const ReadBack back = read_back(folder() / "a.png");
  EXPECT_EQ(back.width, 2U);
  EXPECT_EQ(back.height, 3U);
  EXPECT_EQ(back.bit_depth, 8);
  EXPECT_EQ(back.colour_type, PNG_COLOR_TYPE_RGB);
  EXPECT_EQ(back.bytes, (std::vector<std::uint8_t>{0, 1, 2, 40, 41, 42, 80, 81, 82, 120, 121, 122,
                                                   160, 161, 162, 200, 201, 202}));
}

TEST_F(Png, SaysWhenItCannotBeWritten) {
  const std::filesystem::path file = folder() / "absent" / "a.png";
  const std::expected<void, dataset::Problem> written =
      write_png(file, dataset::Image<Rgb>(1, 1), {});
  ASSERT_FALSE(written);
  test::expect_one_line_about(written.error().message, file, "cannot be written");
}

TEST_F(Png, SaysWhenTheDiskIsFull) {
  if (!std::filesystem::exists("/dev/full")) {
    GTEST_SKIP() << "no /dev/full here";
  }
  const std::expected<void, dataset::Problem> written =
      write_png("/dev/full", dataset::Image<std::uint16_t>(64, 64), {});
  ASSERT_FALSE(written);
  test::expect_one_line_about(written.error().message, "/dev/full", "cannot be written");
}

TEST_F(Png, FollowsNoLinkAndWaitsAtNoPipe) {
  const std::filesystem::path own = put("own", "of somebody else");
  std::filesystem::create_symlink(own, folder() / "a.png");
  ASSERT_EQ(::mkfifo((folder() / "b.png").c_str(), 0600), 0);
  for (const char* const name : {"a.png", "b.png"}) {
    const std::filesystem::path file = folder() / name;
    const auto written = write_png(file, dataset::Image<Rgb>(1, 1), {});
    ASSERT_FALSE(written);
    test::expect_one_line_about(written.error().message, file, "cannot be written");
  }
  EXPECT_EQ(std::filesystem::file_size(own), 16U);
  // A picture of before, which was longer, leaves nothing behind.
  ASSERT_TRUE(write_png(put("c.png", std::string(5000, 'x')), dataset::Image<Rgb>(1, 1), {}));
  EXPECT_LT(std::filesystem::file_size(folder() / "c.png"), 200U);
}

TEST_F(Png, BytesAreThoseOfAFileWithAPaletteWhereItIsEnough) {
  dataset::Image<Rgb> few(16, 16);
  dataset::Image<Rgb> many(16, 17);
  for (std::size_t i = 0; i < many.pixels.size(); ++i) {
    const Rgb colour{static_cast<std::uint8_t>(i / 2), static_cast<std::uint8_t>(i % 251), 7};
    many.pixels[i] = colour;
    if (i < few.pixels.size()) {
      few.pixels[i] = colour;
    }
  }
  const ReadBack palette = read_back(put("few.png", png_bytes(few)));
  EXPECT_EQ(palette.colour_type, PNG_COLOR_TYPE_PALETTE);
  EXPECT_EQ(palette.width, 16U);
  const ReadBack direct = read_back(put("many.png", png_bytes(many)));
  EXPECT_EQ(direct.colour_type, PNG_COLOR_TYPE_RGB);
  ASSERT_EQ(direct.bytes.size(), 3 * many.pixels.size());
  for (std::size_t i = 0; i < many.pixels.size(); ++i) {
    const Rgb back{direct.bytes[3 * i], direct.bytes[3 * i + 1], direct.bytes[3 * i + 2]};
    ASSERT_EQ(back, many.pixels[i]) << i;
  }
}

TEST_F(Png, BytesOfGreyAreTheValues) {
  dataset::Image<std::uint8_t> grey(256, 1);
  std::ranges::generate(grey.pixels, [value = std::uint8_t{0}]() mutable { return value++; });
  const ReadBack back = read_back(put("grey.png", png_bytes(grey)));
  EXPECT_EQ(back.colour_type, PNG_COLOR_TYPE_GRAY);
  EXPECT_EQ(back.bytes, grey.pixels);
}

}  // namespace
}  // namespace stof::host
