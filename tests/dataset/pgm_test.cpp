#include "dataset/dataset.h"
#include "tests/dataset/scratch.h"

namespace stof::dataset {
namespace {

using test::expect_one_line_about;
using namespace std::string_view_literals;

class Pgm : public test::Scratch {};

TEST_F(Pgm, ReadsEightBitPixelsRowByRow) {
  const Loaded<Image<std::uint8_t>> image =
      read_pgm8(put("a.pgm", "P5\n3 2\n255\n\x01\x02\x03\x04\x05\xff"sv));
  ASSERT_TRUE(image) << image.error().message;
  EXPECT_EQ(image->width, 3);
  EXPECT_EQ(image->height, 2);
  EXPECT_EQ(image->pixels, (std::vector<std::uint8_t>{1, 2, 3, 4, 5, 255}));
}

TEST_F(Pgm, ReadsSixteenBitPixelsBigEndian) {
  const Loaded<Image<std::uint16_t>> image =
      read_pgm16(put("a.pgm", "P5 2 1 4095\n\x01\x02\x0f\xff"sv));
  ASSERT_TRUE(image) << image.error().message;
  EXPECT_EQ(image->pixels, (std::vector<std::uint16_t>{0x0102, 0x0fff}));
}

TEST_F(Pgm, WidensEightBitPixelsToSixteen) {
  const Loaded<Image<std::uint16_t>> image = read_pgm16(put("a.pgm", "P5 2 1 200\n\x07\xc8"sv));
  ASSERT_TRUE(image) << image.error().message;
  EXPECT_EQ(image->pixels, (std::vector<std::uint16_t>{7, 200}));
}

TEST_F(Pgm, SkipsCommentsAnywhereInTheHeader) {
  const Loaded<Image<std::uint8_t>> image =
      read_pgm8(put("a.pgm", "P5# one\n#two 9 9\n 2 # three\n1\n#four\n255\n\x0a#"sv));
  ASSERT_TRUE(image) << image.error().message;
  EXPECT_EQ(image->pixels, (std::vector<std::uint8_t>{'\n', '#'}));  // pixels, not header
}

TEST_F(Pgm, RefusesEveryDamagedFileInOneLine) {
  struct Case {
    std::string_view bytes;
    std::string_view fact;
  };
  const Case cases[] = {
      {""sv, "P5"},
      {"P2\n1 1\n255\n7\n"sv, "P5"},
      {"P5"sv, "header"},
      {"P5\n2"sv, "header"},
      {"P5\n2 2\n255"sv, "header"},
      {"P5\n-2 2\n255\n1234"sv, "header"},
      {"P5\n2 2\n255x1234"sv, "header"},
      {"P5\n0x2 2\n255\n1234"sv, "header"},
      {"P5\n99999999999 2\n255\n1234"sv, "header"},
      {"P5\n0 2\n255\n"sv, "impossible"},
      {"P5\n2 2\n0\n1234"sv, "impossible"},
      {"P5\n2 2\n65536\n12341234"sv, "impossible"},
      {"P5\n999999999 999999999\n255\n1234"sv, "67108864"},
      {"P5\n2 2\n255\n123"sv, "truncated, 2x2 pixels take 4 bytes but 3 are there"},
      {"P5\n2 2\n255\n"sv, "truncated"},
      {"P5\n2 2\n255\n12345"sv, "too long"},
      {"P5\n2 2\n4095\n1234"sv, "maxval 4095"},
      {"P5\n2 2\n100\n\x01\x64\x65\x01"sv, "sample 101 above its maxval 100"},
  };
  for (const Case& each : cases) {
    const std::filesystem::path file = put("bad.pgm", each.bytes);
    const Loaded<Image<std::uint8_t>> image = read_pgm8(file);
    ASSERT_FALSE(image) << each.bytes;
    if (each.fact != "maxval 4095") {
      expect_one_line_about(image.error().message, file, each.fact);
    }
  }
}

TEST_F(Pgm, RefusesSixteenBitPixelsWhereEightAreNeeded) {
  const std::filesystem::path file = put("a.pgm", "P5\n2 1\n4095\n1234"sv);
  const Loaded<Image<std::uint8_t>> image = read_pgm8(file);
  ASSERT_FALSE(image);
  expect_one_line_about(image.error().message, file, "16-bit");
}

TEST_F(Pgm, RefusesSixteenBitSamplesAboveTheirMaxval) {
  const std::filesystem::path file = put("a.pgm", "P5\n1 1\n4095\n\x10\x00"sv);
  const Loaded<Image<std::uint16_t>> image = read_pgm16(file);
  ASSERT_FALSE(image);
  expect_one_line_about(image.error().message, file, "4096");
}

TEST_F(Pgm, RefusesWhatIsNotAFile) {
  for (const std::filesystem::path& path :
       {folder() / "absent.pgm", folder(), folder() / "a" / "b"}) {
    const Loaded<Image<std::uint8_t>> image = read_pgm8(path);
    ASSERT_FALSE(image);
    expect_one_line_about(image.error().message, path, "");
  }
}

TEST_F(Pgm, RefusesEveryTruncation) {
  const std::string whole = "P5\n4 3\n255\n" + std::string(12, 'x');
  for (std::size_t length = 0; length < whole.size(); ++length) {
    EXPECT_FALSE(read_pgm8(put("cut.pgm", whole.substr(0, length)))) << length;
  }
  EXPECT_TRUE(read_pgm8(put("whole.pgm", whole)));
}

}  // namespace
}  // namespace stof::dataset
