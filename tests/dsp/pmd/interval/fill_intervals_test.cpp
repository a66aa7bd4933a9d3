#include "dsp/pmd/interval/fill_intervals.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace stof::dsp {
namespace {

constexpr std::uint32_t kRange = 29979;

// Maps with what intervals need, 20 MHz.
struct Frame {
  Frame(int width, int height, bool far = false)
      : w(width),
        h(height),
        distance(padded()),
        sigma(padded()),
        low(plain()),
        high(plain()),
        flags(plain()),
        long_distance(far ? plain() : 0) {
    maps.distance = {distance.data() + 1, w, h, w + 2};
    maps.sigma = {sigma.data() + 1, w, h, w + 2};
    maps.low = {low.data(), w, h};
    maps.high = {high.data(), w, h};
    maps.flags = {flags.data(), w, h};
    if (far) {
      maps.long_distance = {long_distance.data(), w, h};
    }
    maps.range = kRange;
    maps.widest = kRange / 2;
  }
  std::size_t padded() const { return static_cast<std::size_t>((w + 2) * h); }
  std::size_t plain() const { return static_cast<std::size_t>(w * h); }
  void put(int x, int y, int d, int s) const {
    maps.distance.at(x, y) = static_cast<QuarterMm>(d);
    maps.sigma.at(x, y) = static_cast<QuarterMm>(s);
  }
  int w, h;
  std::vector<QuarterMm> distance, sigma, low, high;
  std::vector<std::uint8_t> flags;
  std::vector<std::uint32_t> long_distance;
  PmdMaps maps;
};

TEST(FillIntervals, FollowReadingsThatWereMoved) {
  const Frame frame(4, 1);
  for (int x = 0; x < 4; ++x) {
    frame.put(x, 0, x < 2 ? 29900 : 100, 30);  // a wall at 7.48 to 7.52 m
  }
  fill_intervals(frame.maps, {0, 1});
  EXPECT_TRUE(frame.maps.flags.at(1, 0) & frame.maps.flags.at(2, 0) & kPmdWrapped);
  EXPECT_EQ(frame.maps.high.at(2, 0), 0);
  EXPECT_EQ(frame.maps.distance.at(2, 0), 100);  // still there, to be moved
  for (int x = 2; x < 4; ++x) {
    frame.put(x, 0, static_cast<int>(100 + kRange), 30);
  }
  refresh_intervals(frame.maps);
  for (int x = 0; x < 4; ++x) {
    EXPECT_EQ(frame.maps.flags.at(x, 0) & kPmdMissing, 0) << x;
    EXPECT_EQ(frame.maps.low.at(x, 0), x < 3 ? 29840 : 100 + kRange - 60) << x;
    EXPECT_EQ(frame.maps.high.at(x, 0), x < 1 ? 29960 : 100 + kRange + 60) << x;
  }
}

TEST(FillIntervals, ReadingsThatMayBeMixedAreKeptOfWidePixelsAlone) {
  for (const bool fine : {false, true}) {
    Frame frame(5, 3);
    std::vector<QuarterMm> folded(15);
    std::vector<QuarterMm> folded_sigma(15);
    std::vector<QuarterMm> smoothed(frame.padded());
    std::vector<QuarterMm> smoothed_sigma(frame.padded());
    frame.maps.folded = {folded.data(), 5, 3};
    frame.maps.folded_sigma = {folded_sigma.data(), 5, 3};
    if (fine) {
      frame.maps.smoothed = {smoothed.data() + 1, 5, 3, 7};
      frame.maps.smoothed_sigma = {smoothed_sigma.data() + 1, 5, 3, 7};
    }
    for (int y = 0; y < 3; ++y) {
      for (int x = 0; x < 5; ++x) {
        frame.put(x, y, x < 3 ? 8000 : 27000, 40);
      }
    }
    refresh_intervals(frame.maps);
    EXPECT_EQ(frame.maps.flags.at(2, 1), kPmdWrapped | kPmdEdge);
    EXPECT_EQ(frame.maps.distance.at(2, 1), kNoDepth);
    EXPECT_EQ(frame.maps.folded.at(2, 1), fine ? 0 : 8000);
    EXPECT_EQ(frame.maps.folded_sigma.at(2, 1), fine ? 0 : 40);
    EXPECT_EQ(frame.maps.folded.at(0, 1), 0);
  }
}

TEST(FillIntervals, KeepWhatSamplesSayAndPixelsWithoutDistance) {
  const Frame frame(3, 1);
  frame.put(0, 0, 8000, 20);
  frame.put(1, 0, 0, 0);
  frame.put(2, 0, 8000, 20);
  frame.maps.flags.at(0, 0) = kPmdEdge | kPmdWrapped | kPmdOutOfRange;  // stale: of neighbours
  frame.maps.flags.at(1, 0) = kPmdSaturated | kPmdWrapped | kPmdOutOfRange;
  frame.maps.high.at(1, 0) = 9;
  refresh_intervals(frame.maps);
  EXPECT_EQ(frame.maps.flags.at(0, 0), 0);
  EXPECT_EQ(frame.maps.flags.at(1, 0), kPmdSaturated | kPmdWrapped | kPmdOutOfRange);
  EXPECT_EQ(frame.maps.high.at(1, 0), 0);
  EXPECT_EQ(frame.maps.low.at(2, 0), 7960);
}

TEST(FillIntervals, DropBothDistancesOfAWrappedPixel) {
  const Frame frame(2, 1, true);
  for (int x = 0; x < 2; ++x) {
    frame.put(x, 0, x == 0 ? 1000 : 20000, 20);
    frame.maps.long_distance.at(x, 0) = x == 0 ? 2500 : 50000;
  }
  refresh_intervals(frame.maps);
  for (int x = 0; x < 2; ++x) {
    EXPECT_TRUE(frame.maps.flags.at(x, 0) & kPmdWrapped);
    EXPECT_EQ(frame.maps.distance.at(x, 0) + frame.maps.sigma.at(x, 0), 0);
    EXPECT_EQ(frame.maps.long_distance.at(x, 0), 0U);
  }
}

TEST(FillIntervals, AreTheSameForEverySplitOfRowsAndTheSecondTime) {
  for (const auto& [w, h] : {std::pair{1, 1}, {1, 7}, {7, 1}, {19, 6}}) {
    test::Random random(static_cast<std::uint64_t>(w * 100 + h));
    const Frame whole(w, h);
    const Frame split(w, h);
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) {
        const int d = random.between(0, 3) == 0 ? 0 : random.between(1, 32000);
        const int s = d == 0 ? 0 : random.between(1, 60);
        whole.put(x, y, d, s);
        split.put(x, y, d, s);
      }
    }
    fill_intervals(whole.maps, whole.maps.flags.rows());
    for (int y = h; y-- > 0;) {
      fill_intervals(split.maps, {y, y + 1});
    }
    EXPECT_EQ(whole.low, split.low) << w << "x" << h;
    EXPECT_EQ(whole.high, split.high) << w << "x" << h;
    EXPECT_EQ(whole.flags, split.flags) << w << "x" << h;
    fill_intervals(split.maps, split.maps.flags.rows());
    EXPECT_EQ(whole.flags, split.flags) << w << "x" << h;
  }
}

}  // namespace
}  // namespace stof::dsp
