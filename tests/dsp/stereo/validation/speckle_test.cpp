#include "dsp/stereo/validation/speckle.h"

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/guarded_memory.h"
#include "tests/support/random.h"

namespace stof::dsp {
namespace {

void drop(ImageView<Disparity> image, int min_pixels) {
  test::GuardedBuffer<std::byte> memory(bytes_taken(
      [&](Arena& measuring) { SpeckleScratch(image.width(), image.height(), measuring); }));
  Arena arena(memory.span());
  SpeckleScratch scratch(image.width(), image.height(), arena);
  drop_speckles(image, min_pixels, scratch);
}

// '.' is none, a digit a whole disparity.
std::vector<Disparity> picture(const std::string& text) {
  std::vector<Disparity> out;
  for (const char c : text) {
    out.push_back(c == '.' ? Disparity::none() : Disparity::from_pixels(c - '0'));
  }
  return out;
}

TEST(Speckle, DropsSmallPatchesAndKeepsBentOnes) {
  auto image = picture(
      "11111."
      ".....1"
      "55..11"
      ".5..1."
      "9.1111");
  drop({image.data(), 6, 5}, 6);
  // The upper row touches the hook below by a corner only.
  EXPECT_EQ(image, picture("......"
                           ".....1"
                           "....11"
                           "....1."
                           "..1111"));
}

TEST(Speckle, StepsOfOnePixelConnectAndLargerOnesPart) {
  auto slope = picture("123456");
  drop({slope.data(), 6, 1}, 6);
  EXPECT_EQ(slope, picture("123456"));
  slope[3] = Disparity::from_raw(4 * 16 + 1);  // 17/16 from the third
  drop({slope.data(), 6, 1}, 4);
  EXPECT_EQ(slope, picture("......"));
}

// The plain meaning: flood each patch.
std::vector<Disparity> flooded(std::vector<Disparity> image, int width, int height, int least) {
  std::vector<bool> seen(image.size());
  auto out = image;
  for (int start = 0; start < width * height; ++start) {
    std::vector<int> patch{start};
    if (seen[static_cast<std::size_t>(start)] || !image[static_cast<std::size_t>(start)].valid()) {
      continue;
    }
    seen[static_cast<std::size_t>(start)] = true;
    for (std::size_t k = 0; k < patch.size(); ++k) {
      const int x = patch[k] % width, y = patch[k] / width;
      for (const auto& [nx, ny] : {std::pair{x - 1, y}, {x + 1, y}, {x, y - 1}, {x, y + 1}}) {
        const int at = ny * width + nx;
        if (nx >= 0 && nx < width && ny >= 0 && ny < height &&
            !seen[static_cast<std::size_t>(at)]) {
          const Disparity a = image[static_cast<std::size_t>(patch[k])];
          const Disparity b = image[static_cast<std::size_t>(at)];
          if (b.valid() && std::abs(a.raw - b.raw) <= 16) {
            seen[static_cast<std::size_t>(at)] = true;
            patch.push_back(at);
          }
        }
      }
    }
    for (const int at : patch) {
      if (static_cast<int>(patch.size()) < least) {
        out[static_cast<std::size_t>(at)] = Disparity::none();
      }
    }
  }
  return out;
}

TEST(Speckle, EqualsFloodingOnRandomPictures) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    test::Random random(seed);
    const int width = random.between(1, seed % 3 == 0 ? 200 : 24);
    const int height = random.between(1, 24);
    std::vector<Disparity> image(static_cast<std::size_t>(width * height));
    const int levels = random.between(1, 4);
    for (Disparity& disparity : image) {
      disparity =
          random.between(0, 4) == 0
              ? Disparity::none()
              : Disparity::from_raw(static_cast<std::int16_t>(10 * random.between(0, levels)));
    }
    image[image.size() / 2] = Disparity::from_raw(-32767);  // next to none, and to 32767 in 16 bits
    image.back() = Disparity::from_raw(seed % 2 == 0 ? 32767 : -32767);
    const int least = random.between(0, 12);
    const auto expected = flooded(image, width, height, least);
    drop({image.data(), width, height}, least);
    ASSERT_EQ(image, expected) << "seed " << seed;
  }
}

TEST(Speckle, OnePatchOfASpiralFillsALargeImage) {
  const int size = 301;
  test::GuardedImage<Disparity> image(size, size, size, Disparity::none());
  for (int y = 0; y < size; ++y) {  // a comb: every second row, joined at alternating ends
    for (int x = 0; x < size; ++x) {
      if (y % 2 == 0 || x == (y % 4 == 1 ? size - 1 : 0)) {
        image.view().at(x, y) = Disparity::from_pixels(3);
      }
    }
  }
  const int pixels = size * 151 + 150;
  drop(image.view(), pixels);
  EXPECT_TRUE(image.view().at(0, 0).valid());
  drop(image.view(), pixels + 1);
  EXPECT_FALSE(image.view().at(0, 0).valid());
  EXPECT_FALSE(image.view().at(size - 1, size - 1).valid());
}

}  // namespace
}  // namespace stof::dsp
