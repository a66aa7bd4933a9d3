#include "host/client/session/health_book.h"

#include <chrono>

#include <gtest/gtest.h>

namespace stof::client {
namespace {

using namespace std::chrono_literals;
using Verdict = HealthBook::Verdict;

// A sensor's clock and this machine's run alike; uptimes are milliseconds after the start.
class Healths : public testing::Test {
 protected:
  Verdict say(Duration at, wire::Reaction reaction, Duration ahead = 0ms) {
    const auto uptime = std::chrono::duration_cast<std::chrono::milliseconds>(at + ahead);
    const auto count = static_cast<std::uint64_t>(uptime.count());
    return book_.take({.uptime_ms = count, .reaction = reaction}, Time(100s) + at);
  }
  Verdict good(Duration at, Duration ahead = 0ms) { return say(at, wire::Reaction{}, ahead); }
  Verdict stop(Duration at) { return say(at, wire::Reaction::kStop); }
  bool stops() const { return book_.current()->reaction == wire::Reaction::kStop; }

  HealthBook book_;
};

TEST_F(Healths, WhatHealsIsBelievedAtOnce) {
  good(10s);
  stop(10300ms);
  EXPECT_TRUE(stops());
  good(10400ms);
  EXPECT_FALSE(stops());
  EXPECT_EQ(book_.lies(), 0U);
}

TEST_F(Healths, WhatHealsTwiceIsBelievedWhenItLasts) {
  good(10s);
  stop(11s);
  good(11100ms);
  stop(12s);
  good(12100ms);
  EXPECT_TRUE(stops());
  good(13100ms);
  EXPECT_TRUE(stops());
  good(13300ms);
  EXPECT_FALSE(stops());
  EXPECT_EQ(book_.lies(), 0U);
}

// Of somebody whose clock is ahead: each of his makes the sensor's late.
TEST_F(Healths, NobodyHidesAStopForLongerThanASecond) {
  for (const Duration ahead : {1900ms, 300ms, 50ms, 0ms}) {
    book_ = {};
    Duration hidden = 0ms;
    for (Duration at = 10s; at < 20s; at += 10ms) {
      if (at % 1s == 0ms) {
        at < 12s ? good(at) : stop(at);
      }
      if (at > 11s && at % 40ms == 0ms) {
        good(at + 1ns, ahead);
      }
      hidden += at >= 12s && !stops() ? 10ms : 0ms;
    }
    EXPECT_LE(hidden, 1s) << ahead.count();
    EXPECT_TRUE(stops()) << ahead.count();
    if (ahead != 0ms) {
      EXPECT_GT(book_.lies(), 0U) << ahead.count();
    }
  }
}

TEST_F(Healths, WhatTheNetworkTurnsRoundIsNoLie) {
  for (Duration at = 10s; at < 40s; at += 11s) {
    good(at + 20ms);
    EXPECT_EQ(good(at + 30ms, -20ms), Verdict::kLate);
  }
  EXPECT_EQ(book_.lies(), 0U);
}

TEST_F(Healths, WhatIsWorseIsBelievedHoweverLate) {
  good(10s);
  EXPECT_EQ(say(10010ms, wire::Reaction::kStop, -20ms), Verdict::kLate);
  EXPECT_TRUE(stops());
  EXPECT_EQ(book_.lies(), 0U);
}

TEST_F(Healths, OneThatIsASecondLateIsALie) {
  good(10s);
  good(11s);
  EXPECT_EQ(say(11500ms, wire::Reaction::kStop, -1s), Verdict::kLate);
  EXPECT_EQ(book_.lies(), 1U);
  EXPECT_TRUE(stops());
  book_.restart();
  EXPECT_FALSE(book_.current());
  EXPECT_EQ(book_.lies(), 1U);
}

}  // namespace
}  // namespace stof::client
