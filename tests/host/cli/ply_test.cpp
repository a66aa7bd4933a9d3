#include "host/cli/view/ply.h"

#include <bit>
#include <cstring>

#include <gtest/gtest.h>

#include "tests/dataset/scratch.h"

namespace stof::host {
namespace {

class Ply : public test::Scratch {
 protected:
  std::string written(const std::vector<client::Point>& cloud) const {
    const std::filesystem::path file = folder() / "cloud.ply";
    EXPECT_TRUE(write_ply(file, cloud));
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
};

constexpr std::string_view kEnd = "end_header\n";

float little_endian(std::string_view bytes) {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    word |= std::uint32_t{static_cast<std::uint8_t>(bytes[i])} << (8 * i);
  }
  return std::bit_cast<float>(word);
}

TEST_F(Ply, HasAHeaderThatDescribesEveryByte) {
  const std::string bytes =
      written({{.x = 1, .y = -2, .z = 3, .z_width = 0.5F, .source = dsp::Source::kPmd},
               {.x = 4, .y = 5, .z = 6, .z_width = 1, .source = dsp::Source::kBoth}});
  EXPECT_TRUE(bytes.starts_with("ply\nformat binary_little_endian 1.0\n"));
  const std::size_t end = bytes.find(kEnd);
  ASSERT_NE(end, std::string::npos);
  const std::string header = bytes.substr(0, end);
  const std::string vertices =
      "element vertex 2\nproperty float x\nproperty float y\nproperty float z\nproperty float "
      "sigma\nproperty uchar source\n";
  EXPECT_TRUE(header.ends_with(vertices)) << header;
  const std::string_view points = std::string_view(bytes).substr(end + kEnd.size());
  ASSERT_EQ(points.size(), 2 * 17U);
  const float expected[] = {1, -2, 3, 0.125F};  // sigma: a quarter of the interval
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(little_endian(points.substr(4 * i)), expected[i]);
  }
  EXPECT_EQ(points[16], 2);
  EXPECT_EQ(little_endian(points.substr(17)), 4);
  EXPECT_EQ(points[33], 3);
}

TEST_F(Ply, OfNoPointsIsAHeader) {
  const std::string bytes = written({});
  EXPECT_NE(bytes.find("element vertex 0\n"), std::string::npos);
  EXPECT_TRUE(bytes.ends_with(kEnd));
}

TEST_F(Ply, SaysWhenItCannotBeWritten) {
  const std::filesystem::path file = folder() / "absent" / "a.ply";
  const std::expected<void, dataset::Problem> result = write_ply(file, {});
  ASSERT_FALSE(result);
  test::expect_one_line_about(result.error().message, file, "cannot be written");
}

}  // namespace
}  // namespace stof::host
