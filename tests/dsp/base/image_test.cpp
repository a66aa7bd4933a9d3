#include "dsp/base/image.h"

#include <array>

#include <gtest/gtest.h>

namespace stof::dsp {
namespace {

TEST(ImageView, RowsFollowTheStrideAndBordersReplicate) {
  const std::array<std::uint8_t, 10> pixels{1, 2, 3, 99, 99, 4, 5, 6, 99, 99};
  const ImageView<const std::uint8_t> image(pixels.data(), 3, 2, 5);
  EXPECT_EQ(image.at(0, 1), 4);
  EXPECT_EQ(image.row(1).size(), 3U);
  EXPECT_EQ(image.row_clamped(-7)[2], 3);
  EXPECT_EQ(image.row_clamped(50)[2], 6);
}

TEST(ImageViewDeathTest, RowsOutsideAreOurOwnBug) {
  std::array<std::uint8_t, 4> pixels{};
  const ImageView<std::uint8_t> image(pixels.data(), 2, 2);
  EXPECT_DEATH(image.row(2), "internal error");
  EXPECT_DEATH(image.at(-1, 0), "internal error");
  EXPECT_DEATH((ImageView<std::uint8_t>(pixels.data(), 2, 2, 1)), "internal error");
}

}  // namespace
}  // namespace stof::dsp
