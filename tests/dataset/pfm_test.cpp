#include <cmath>
#include <limits>

#include "dataset/dataset.h"
#include "tests/dataset/scratch.h"

namespace stof::dataset {
namespace {

using test::expect_one_line_about;
using namespace std::string_view_literals;

class Pfm : public test::Scratch {};

Image<float> two_by_two() {
  Image<float> image(2, 2);
  image.pixels = {1.0F, std::numeric_limits<float>::infinity(), -2.0F, 0.5F};  // top row first
  return image;
}

TEST_F(Pfm, WritesTheBottomRowFirstInLittleEndian) {
  const std::filesystem::path file = folder() / "a.pfm";
  ASSERT_TRUE(write_pfm(file, two_by_two()));
  std::ifstream stream(file, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(stream), {});
  EXPECT_EQ(bytes,
            "Pf\n2 2\n-1\n"
            "\x00\x00\x00\xc0\x00\x00\x00\x3f"      // -2, 0.5
            "\x00\x00\x80\x3f\x00\x00\x80\x7f"sv);  // 1, +inf
}

TEST_F(Pfm, ReadsBackWhatItWrote) {
  const std::filesystem::path file = folder() / "a.pfm";
  ASSERT_TRUE(write_pfm(file, two_by_two()));
  const Loaded<Image<float>> image = read_pfm(file);
  ASSERT_TRUE(image) << image.error().message;
  EXPECT_EQ(image->width, 2);
  EXPECT_EQ(image->height, 2);
  EXPECT_EQ(image->pixels, two_by_two().pixels);
}

TEST_F(Pfm, RefusesEveryDamagedFileInOneLine) {
  struct Case {
    std::string_view bytes;
    std::string_view fact;
  };
  const Case cases[] = {
      {""sv, "Pf"},
      {"PF\n1 1\n-1\n123412341234"sv, "Pf"},
      {"Pf\n1 1\n1\n1234"sv, "scale"},  // big-endian
      {"Pf\n1 1\nnan\n1234"sv, "scale"},
      {"Pf\n1 1\n-inf\n1234"sv, "scale"},
      {"Pf\n0 1\n-1\n"sv, "header"},
      {"Pf\n1 1\n-1\n123"sv, "take 4 bytes but 3 are there"},
      {"Pf\n1 1\n-1\n12345"sv, "take 4 bytes but 5 are there"},
      {"Pf\n999999999 999999999\n-1\n1234"sv, "wrong length"},
  };
  for (const Case& each : cases) {
    const std::filesystem::path file = put("bad.pfm", each.bytes);
    const Loaded<Image<float>> image = read_pfm(file);
    ASSERT_FALSE(image) << each.bytes;
    expect_one_line_about(image.error().message, file, each.fact);
  }
}

TEST_F(Pfm, SaysWhenItCannotWrite) {
  const std::filesystem::path file = folder() / "absent" / "a.pfm";
  const std::expected<void, Problem> written = write_pfm(file, two_by_two());
  ASSERT_FALSE(written);
  expect_one_line_about(written.error().message, file, "cannot be written");
}

}  // namespace
}  // namespace stof::dataset
