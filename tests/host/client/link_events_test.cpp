#include "host/client/session/link_events.h"

#include <chrono>

#include <gtest/gtest.h>

namespace stof::client {
namespace {

using namespace std::chrono_literals;

constexpr Time kStart{1000s};
constexpr LinkState kWell{.silent = false};

TEST(LinkEvents, TellsWhatBeginsAndEndsOnce) {
  LinkEvents events;
  events.look(kWell, 0, kStart);
  EXPECT_FALSE(events.take());
  events.look({.silent = true}, 1, kStart + 1s);
  events.look({.silent = true, .forged_traffic = true}, 1, kStart + 2s);
  events.look(kWell, 1, kStart + 3s);
  struct Told {
    LinkCondition condition;
    bool active;
    Time at;
  };
  for (const Told& told : {Told{LinkCondition::kSilent, true, kStart + 1s},
                           Told{LinkCondition::kForged, true, kStart + 2s},
                           Told{LinkCondition::kSilent, false, kStart + 3s},
                           Told{LinkCondition::kForged, false, kStart + 3s}}) {
    const auto event = events.take();
    ASSERT_TRUE(event);
    EXPECT_EQ(event->condition, told.condition);
    EXPECT_EQ(event->active, told.active);
    EXPECT_EQ(event->at, told.at);
    EXPECT_EQ(event->count, 1U);
  }
  EXPECT_FALSE(events.take());
}

// However short it was, and also where two lie between two looks.
TEST(LinkEvents, MissesNoRestart) {
  LinkEvents events;
  events.look(kWell, 1, kStart);
  EXPECT_FALSE(events.take()) << "the first session is no restart";
  events.look(kWell, 2, kStart + 1s);
  events.look(kWell, 2, kStart + 2s);
  events.look(kWell, 4, kStart + 3s);
  for (std::uint32_t count = 1; count <= 3; ++count) {
    const auto event = events.take();
    ASSERT_TRUE(event);
    EXPECT_EQ(event->condition, LinkCondition::kRestarted);
    EXPECT_TRUE(event->active);
    EXPECT_EQ(event->count, count);
  }
  EXPECT_FALSE(events.take());
  EXPECT_EQ(events.restarts(), 3U);
}

TEST(LinkEvents, KeepsTheNewest) {
  LinkEvents events;
  for (int i = 0; i < 500; ++i) {
    events.look({.silent = i % 2 == 0}, 1, kStart + i * 1s);
  }
  std::size_t kept = 0;
  std::optional<LinkEvent> last;
  for (auto event = events.take(); event; event = events.take()) {
    last = event;
    ++kept;
  }
  EXPECT_EQ(kept, LinkEvents::kMostKept);
  ASSERT_TRUE(last);
  EXPECT_FALSE(last->active);
  EXPECT_EQ(last->count, 250U);
}

}  // namespace
}  // namespace stof::client
