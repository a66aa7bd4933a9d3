#include "dsp/stereo/validation/texture.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded_memory.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

constexpr int kCap = 15;

std::vector<Disparity> drop(ImageView<const std::uint8_t> derivative, int min_texture,
                            const std::vector<Rows>& parts) {
  const std::size_t pixels =
      static_cast<std::size_t>(derivative.width()) * static_cast<std::size_t>(derivative.height());
  std::vector<Disparity> out(pixels, Disparity::from_pixels(5));
  test::GuardedBuffer<std::byte> memory(
      bytes_taken([&](Arena& measuring) { WindowSums(derivative.width(), measuring); }));
  Arena arena(memory.span());
  WindowSums window(derivative.width(), arena);
  for (const Rows part : parts) {
    drop_flat(derivative, kCap, min_texture, part, window,
              {out.data(), derivative.width(), derivative.height()});
  }
  return out;
}

TEST(Texture, DropsWhatIsFlatAndKeepsWhatIsNot) {
  test::GuardedImage<std::uint8_t> image(96, 60, 100, kCap);
  for (int y = 0; y < 60; ++y) {
    for (int x = 48; x < 96; ++x) {
      image.view().at(x, y) = (x + y) % 2 == 0 ? kCap + 4 : kCap - 4;  // |derivative| 4
    }
  }
  const auto out = drop(image.view(), 3, {{0, 60}});
  for (int y = 0; y < 60; ++y) {
    const std::size_t row = static_cast<std::size_t>(y) * 96;
    EXPECT_FALSE(out[row].valid());
    EXPECT_FALSE(out[row + 48].valid());  // columns 36 .. 59: half is flat, mean 2
    EXPECT_TRUE(out[row + 95].valid());
    EXPECT_TRUE(out[row + 60].valid());
  }
}

TEST(Texture, TheMeanItselfIsEnough) {
  test::GuardedImage<std::uint8_t> image(40, 40, 40, kCap + 4);
  EXPECT_TRUE(std::ranges::all_of(drop(image.view(), 4, {{0, 40}}), &Disparity::valid));
  EXPECT_TRUE(std::ranges::none_of(drop(image.view(), 5, {{0, 40}}), &Disparity::valid));
}

TEST(Texture, EverySplitAndSizeGivesTheMeanOfTheReplicatedWindow) {
  for (const int width : {1, 2, 23, 24, 50}) {
    for (const int height : {1, 13, 30}) {
      test::GuardedImage<std::uint8_t> image(width, height, width + 3);
      test::Random random(static_cast<std::uint64_t>(width * 100 + height));
      for (int y = 0; y < height; ++y) {
        random.fill(image.view().row(y), kCap - 6, kCap + 6);
      }
      const auto whole = drop(image.view(), 3, {{0, height}});
      EXPECT_EQ(whole, drop(image.view(), 3,
                            {{height / 2, height}, {0, height / 3}, {height / 3, height / 2}}));
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          int sum = 0;
          for (int dy = -12; dy < 12; ++dy) {
            for (int dx = -12; dx < 12; ++dx) {
              sum +=
                  std::abs(image.view().row_clamped(
                               y + dy)[static_cast<std::size_t>(std::clamp(x + dx, 0, width - 1))] -
                           kCap);
            }
          }
          ASSERT_EQ(whole[static_cast<std::size_t>(y * width + x)].valid(), sum >= 3 * 24 * 24);
        }
      }
    }
  }
}

}  // namespace
}  // namespace stof::dsp
