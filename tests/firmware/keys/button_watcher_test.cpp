#include "firmware/keys/button_watcher.h"

#include <gtest/gtest.h>

#include "hal/emu/devices/button.h"

namespace stof::keys {
namespace {

using namespace std::chrono_literals;
using Meaning = ButtonWatcher::Meaning;

hal::Time now{1000s};
hal::Time read_now() noexcept { return now; }

class ButtonWatcherTest : public testing::Test {
 protected:
  struct Counts {
    int presses = 0;
    int holds = 0;
  };
  // What is meant in that time, looked at every 20 ms.
  Counts after(hal::Duration time) {
    Counts counts;
    for (const hal::Time end = now + time; now < end; now += 20ms) {
      const Meaning meaning = watcher_.tick(now);
      counts.presses += meaning == Meaning::kPress ? 1 : 0;
      counts.holds += meaning == Meaning::kHold ? 1 : 0;
    }
    return counts;
  }

  hal::emu::Button button_{&read_now};
  ButtonWatcher watcher_{button_};
};

TEST_F(ButtonWatcherTest, TellsAPressWhenItEnds) {
  static_cast<void>(after(100ms));
  button_.press(300ms);
  EXPECT_EQ(after(280ms).presses, 0);
  const Counts counts = after(1s);
  EXPECT_EQ(counts.presses, 1);
  EXPECT_EQ(counts.holds, 0);
}

TEST_F(ButtonWatcherTest, TellsAHoldAfterThreeSecondsAndNoPressBehindIt) {
  static_cast<void>(after(100ms));
  button_.press(10s);
  EXPECT_EQ(after(2900ms).holds, 0);
  EXPECT_EQ(after(300ms).holds, 1);
  const Counts counts = after(20s);
  EXPECT_EQ(counts.holds, 0);
  EXPECT_EQ(counts.presses, 0);
}

TEST_F(ButtonWatcherTest, BouncesAreNothing) {
  static_cast<void>(after(100ms));
  for (int i = 0; i < 20; ++i) {
    button_.press(20ms);
    const Counts counts = after(60ms);
    EXPECT_EQ(counts.presses + counts.holds, 0);
  }
  // Each gap is too short to end the press.
  int presses = 0;
  for (int i = 0; i < 50; ++i) {
    button_.press(180ms);
    presses += after(200ms).presses;
  }
  EXPECT_EQ(presses, 0);
}

TEST_F(ButtonWatcherTest, OneThatIsHeldAtTheStartSaysNothing) {
  button_.press(10s);
  Counts counts = after(20s);
  EXPECT_EQ(counts.presses + counts.holds, 0);
  button_.press(300ms);
  counts = after(1s);
  EXPECT_EQ(counts.presses, 1);
}

TEST_F(ButtonWatcherTest, OneThatCannotBeReadSaysNothing) {
  static_cast<void>(after(100ms));
  button_.press(10s);
  static_cast<void>(after(1s));
  button_.break_down(Status::kDeviceError);
  Counts counts = after(5s);
  button_.break_down(Status::kOk);
  counts.holds += after(20s).holds;
  EXPECT_EQ(counts.presses + counts.holds, 0);
}

}  // namespace
}  // namespace stof::keys
