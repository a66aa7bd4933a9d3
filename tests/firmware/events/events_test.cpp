#include "firmware/events/events.h"

#include <chrono>

#include <gtest/gtest.h>

#include "firmware/events/change_lines.h"

namespace stof::firmware {
namespace {

TEST(Events, AFullRingKeepsTheOldestAndCountsTheRest) {
  Events events;
  for (std::uint32_t i = 0; i < 100; ++i) {
    events.note({.kind = EventKind::kLate, .value = i});
  }
  EXPECT_EQ(events.counters.lost_events, 36U);
  for (std::uint32_t i = 0; i < 64; ++i) {
    EXPECT_EQ(events.take().value().value, i);
  }
  EXPECT_FALSE(events.take());
}

// A stranger may change an unpaired sensor's harmless settings some hundred times a second.
TEST(ChangeLines, TenAfterARestThenOneASecondThatCountsTheOthers) {
  ChangeLines lines;
  int told = 0;
  for (int ms = 0; ms < 60'000; ms += 10) {
    const Event change{.at = hal::Time(std::chrono::milliseconds(ms)),
                       .kind = EventKind::kSettingsChanged};
    told += lines.take(change) ? 1 : 0;
    EXPECT_TRUE(lines.take({.at = change.at, .kind = EventKind::kKeyMade}));
  }
  EXPECT_EQ(told, 10 + 59);
  EXPECT_EQ(lines.take_untold(), 6000U - 69U);
  EXPECT_EQ(lines.take_untold(), 0U);
}

}  // namespace
}  // namespace stof::firmware
