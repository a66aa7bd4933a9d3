#include "firmware/events/events.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace stof::firmware
