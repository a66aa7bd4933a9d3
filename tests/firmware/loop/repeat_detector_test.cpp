#include "firmware/loop/repeat_detector.h"

#include <array>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/base/random.h"

namespace stof::firmware {
namespace {

// A picture with noise around a level, in rows of some stride.
class Picture {
 public:
  Picture(int width, int height, int level, std::uint64_t seed, unsigned spread = 3)
      : width_(width), height_(height), pixels_(static_cast<std::size_t>(stride() * height)) {
    dsp::SplitMix64 random(seed);
    for (std::uint8_t& pixel : pixels_) {
      pixel = static_cast<std::uint8_t>(level + static_cast<int>(random.next() % spread));
    }
  }
  dsp::ImageView<const std::uint8_t> view() const {
    return {pixels_.data(), width_, height_, stride()};
  }
  std::uint8_t& at(int x, int y) { return pixels_[static_cast<std::size_t>(y * stride() + x)]; }

 private:
  std::ptrdiff_t stride() const { return width_ + 5; }

  int width_;
  int height_;
  std::vector<std::uint8_t> pixels_;
};

bool repeats(RepeatDetector<std::uint8_t>& detector, const Picture& picture) {
  const auto view = picture.view();
  return detector.repeats({&view, 1});
}

RepeatDetector<std::uint8_t> detector() { return {16, 240}; }

TEST(RepeatDetector, TheSamePixelsAgainAreARepetitionEachTime) {
  auto of = detector();
  const Picture first(640, 480, 100, 1);
  EXPECT_FALSE(repeats(of, first));
  EXPECT_TRUE(repeats(of, first));
  EXPECT_TRUE(repeats(of, Picture(first))) << "also from another buffer";
  EXPECT_FALSE(repeats(of, Picture(640, 480, 100, 2)));
  EXPECT_FALSE(repeats(of, first)) << "only the one before counts";
}

TEST(RepeatDetector, NoiseMakesPicturesOfOneSceneDiffer) {
  auto of = detector();
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    ASSERT_FALSE(repeats(of, Picture(64, 48, 30, seed, 2))) << seed;
  }
}

TEST(RepeatDetector, OnePixelOfARowThatItLooksAtIsEnough) {
  for (int width = 1; width < 80; ++width) {
    for (int x = 0; x < width; ++x) {
      auto of = detector();
      Picture picture(width, 17, 100, 1);
      static_cast<void>(repeats(of, picture));
      ++picture.at(x, 16);
      ASSERT_FALSE(repeats(of, picture)) << x << " of " << width;
      ASSERT_TRUE(repeats(of, picture)) << "what lies between rows does not count";
    }
  }
}

// A covered lens, a blinded one, a few hot pixels on top: such pictures may be equal by themselves.
TEST(RepeatDetector, WhereThereIsNoNoiseEqualPicturesProveNothing) {
  for (const int level : {0, 3, 16, 240, 255}) {
    auto of = detector();
    Picture picture(640, 480, level, 1, 1);
    picture.at(100, 16) = 100;
    picture.at(200, 32) = 101;
    for (int i = 0; i < 5; ++i) {
      EXPECT_FALSE(repeats(of, picture)) << level;
    }
  }
}

TEST(RepeatDetector, SeveralImagesAreOnePicture) {
  RepeatDetector<std::uint16_t> of(0, 4095);
  std::array<std::vector<std::uint16_t>, 4> planes;
  std::array<dsp::ImageView<const std::uint16_t>, 4> views;
  for (std::size_t k = 0; k < 4; ++k) {
    planes[k].assign(std::size_t{32} * 24, static_cast<std::uint16_t>(900 + k));
    views[k] = {planes[k].data(), 32, 24};
  }
  EXPECT_FALSE(of.repeats(views));
  EXPECT_TRUE(of.repeats(views));
  planes[3][5] += 1;
  EXPECT_FALSE(of.repeats(views));
  std::swap(views[0], views[1]);
  EXPECT_FALSE(of.repeats(views));
}

}  // namespace
}  // namespace stof::firmware
