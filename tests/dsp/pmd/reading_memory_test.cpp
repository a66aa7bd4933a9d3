#include "dsp/pmd/reading_memory.h"

#include <array>

#include <gtest/gtest.h>

#include "dsp/pmd/pmd_maps.h"
#include "tests/support/guarded_part.h"

namespace stof::dsp {
namespace {

constexpr int kWidth = 24;
constexpr int kHeight = 16;
constexpr std::uint32_t kRatioQ16 = 39322;  // 0.3: 76 of 256; five eighths of that are 47

// A flat picture of which one pixel, (9, 6), is looked at.
class Camera {
 public:
  Camera()
      : memory_([](Arena& arena) { return ReadingMemory(kWidth, kHeight, kRatioQ16, arena); }) {}
  ReadingMemory& memory() { return *memory_; }

  // Whether the pixel has a distance; offset: brightness there; elsewhere: of two pixels nearby.
  bool run(int ratio, int distance = 20000, int offset = 300, int elsewhere = 300) {
    bool has = false;
    memory_->begin_frame();
    for (int y = 0; y < kHeight; ++y) {
      std::array<std::uint8_t, kWidth> ratios;
      std::array<std::uint16_t, kWidth> offsets;
      std::array<std::uint8_t, kWidth> flags{};
      std::array<QuarterMm, kWidth> distances;
      std::array<QuarterMm, kWidth> sigmas;
      ratios.fill(static_cast<std::uint8_t>(y == 6 ? ratio : 100));
      offsets.fill(static_cast<std::uint16_t>(y == 6 ? offset : 300));
      offsets[12] = offsets[13] = static_cast<std::uint16_t>(elsewhere);
      distances.fill(static_cast<QuarterMm>(distance));
      sigmas.fill(100);
      const bool low = ratios[9] < 76;
      flags[9] = low ? std::uint8_t{kPmdLowRatio} : std::uint8_t{0};
      memory_->admit(y, ratios, offsets, flags);
      if ((flags[9] & kPmdLowRatio) != 0) {
        distances[9] = kNoDepth;
        sigmas[9] = 0;
      }
      memory_->settle(y, flags, distances, sigmas);
      EXPECT_EQ((flags[9] & kPmdLowRatio) != 0, distances[9] == kNoDepth);
      EXPECT_EQ(distances[9] == kNoDepth, sigmas[9] == 0);
      has = y == 6 ? distances[9] != kNoDepth : has;
    }
    return has;
  }
  void stand(int frames = 12) {
    for (int i = 0; i < frames; ++i) {
      EXPECT_TRUE(run(80));
    }
  }

 private:
  test::GuardedPart<ReadingMemory> memory_;
};

TEST(ReadingMemory, AReadingThatWasAcceptedStaysDownToFiveEighthsOfTheRatio) {
  Camera camera;
  EXPECT_FALSE(camera.run(75));
  camera.stand();
  for (const int ratio : {75, 60, 47}) {
    EXPECT_TRUE(camera.run(ratio)) << ratio;
  }
  EXPECT_FALSE(camera.run(46));
  EXPECT_FALSE(camera.run(75));  // it was not there in the frame before
}

TEST(ReadingMemory, AnotherReadingOrAnotherBrightnessHasToBeAcceptedByItself) {
  for (const int way : {0, 1, 2, 3, 4, 5}) {
    Camera camera;
    camera.stand();
    switch (way) {
      case 0:
        EXPECT_FALSE(camera.run(70, 20000 + 300 + 330));
        break;
      case 1:
        EXPECT_FALSE(camera.run(70, 20000 - 300 - 330));
        break;
      case 2:
        EXPECT_FALSE(camera.run(70, 20000, 330));
        break;
      case 3:
        camera.memory().forget();
        EXPECT_FALSE(camera.run(70));
        break;
      case 4:
        EXPECT_TRUE(camera.run(70, 20000 + 300, 315));
        break;
      default:
        camera.run(80, 20000, 300, 400);  // beside it
        EXPECT_FALSE(camera.run(70, 20000, 300, 400));
        for (int frame = 0; frame < ReadingMemory::kQuietFrames; ++frame) {
          camera.run(80, 20000, 300, 400);
        }
        EXPECT_TRUE(camera.run(70, 20000, 300, 400));
    }
  }
}

TEST(ReadingMemory, NothingStaysInTheFirstFrames) {
  Camera camera;
  camera.stand(ReadingMemory::kQuietFrames - 2);
  EXPECT_FALSE(camera.run(70));
}

}  // namespace
}  // namespace stof::dsp
