#include "dsp/fusion/unwrap/decision/wrap_memory.h"

#include <gtest/gtest.h>

#include "tests/support/guarded_part.h"

namespace stof::dsp {
namespace {

constexpr int kRangeOfTurn = 29979;  // 20 MHz, quarter mm

// One reading, frame after frame.
class Reading1 {
 public:
  Reading1()
      : maps_([](Arena& arena) { return WrapMaps(1, 1, arena); }),
        memory_([](Arena& arena) { return WrapMemory(1, arena); }) {
    maps_->range = kRangeOfTurn;
    maps_->wrap_counts = 3;
    maps_->mixed[0] = 0;
    allow(0b111);
  }
  void allow(std::uint16_t counts) { maps_->possible[0] = counts; }
  void mix(std::uint16_t counts) { maps_->mixed[0] = counts; }
  WrapMemory& memory() { return *memory_; }

  // What is told in place of what this frame decides.
  int run(std::int8_t decided, int distance = 8000, int sigma = 40) {
    maps_->readings[0] = {.distance = static_cast<QuarterMm>(distance),
                          .sigma = static_cast<QuarterMm>(sigma),
                          .amp2 = 100};
    maps_->wraps[0] = decided;
    memory_->steady(*maps_);
    return maps_->wraps[0];
  }

 private:
  test::GuardedPart<WrapMaps> maps_;
  test::GuardedPart<WrapMemory> memory_;
};

TEST(WrapMemory, KeepsWhatWasDecidedMoreOftenThanNot) {
  Reading1 reading;
  EXPECT_EQ(reading.run(kRefutedWraps), kRefutedWraps);
  EXPECT_EQ(reading.run(1), 1);
  EXPECT_EQ(reading.run(kRefutedWraps), kRefutedWraps);  // one decision is not enough
  EXPECT_EQ(reading.run(1), 1);
  EXPECT_EQ(reading.run(1), 1);
  EXPECT_EQ(reading.run(kRefutedWraps), 1);
  for (int frame = 0; frame < 20; ++frame) {
    EXPECT_EQ(reading.run(1), 1);
  }
  int kept = 0;
  while (reading.run(kRefutedWraps) == 1) {
    ++kept;
  }
  EXPECT_EQ(kept, WrapMemory::kMost - WrapMemory::kEnough + 1);
}

TEST(WrapMemory, KeepsNothingOfAnotherReadingOrAgainstThisFrame) {
  for (const int way : {0, 1, 2, 3, 4}) {
    Reading1 reading;
    for (int frame = 0; frame < 10; ++frame) {
      reading.run(2);
    }
    if (way == 0) {
      EXPECT_EQ(reading.run(kRefutedWraps, 8000 + 120 + 130), kRefutedWraps);
      EXPECT_EQ(reading.run(kRefutedWraps), kRefutedWraps);  // and it is forgotten
    } else if (way == 1) {
      reading.allow(0b011);
      EXPECT_EQ(reading.run(kRefutedWraps), kRefutedWraps);
    } else if (way == 2) {
      reading.mix(0b100);
      EXPECT_EQ(reading.run(kRefutedWraps), kRefutedWraps);
    } else if (way == 3) {
      reading.memory().forget();
      EXPECT_EQ(reading.run(kRefutedWraps), kRefutedWraps);
    } else {
      EXPECT_EQ(reading.run(kRefutedWraps, 8000 + 120), 2);
    }
  }
}

TEST(WrapMemory, DoesNotBelieveAnotherCountUntilItHasMoreVotes) {
  Reading1 reading;
  for (int frame = 0; frame < 10; ++frame) {
    reading.run(0);
  }
  EXPECT_EQ(reading.run(1), kDisputedWraps);
  EXPECT_EQ(reading.run(1), kDisputedWraps);
  EXPECT_EQ(reading.run(1), 1);
  EXPECT_EQ(reading.run(1), 1);
}

TEST(WrapMemory, LeavesPixelsWithoutAReadingAlone) {
  Reading1 reading;
  for (int frame = 0; frame < 10; ++frame) {
    reading.run(1);
  }
  EXPECT_EQ(reading.run(kNoReading, 0), kNoReading);
  EXPECT_EQ(reading.run(kRefutedWraps), 1);
}

}  // namespace
}  // namespace stof::dsp
