#include "host/client/session/health_book.h"

#include <chrono>
#include <functional>
#include <map>
#include <random>

#include <gtest/gtest.h>

namespace stof::client {
namespace {

using namespace std::chrono_literals;
using std::chrono::milliseconds;
using Verdict = HealthBook::Verdict;

// A sensor's clock and this machine's run alike; uptimes are milliseconds after the start.
class Healths : public testing::Test {
 protected:
  static wire::HealthReport report(Duration uptime, wire::Reaction reaction) {
    const auto count = std::chrono::duration_cast<milliseconds>(uptime).count();
    const bool stops = reaction == wire::Reaction::kStop;
    return {.uptime_ms = static_cast<std::uint64_t>(count),
            .severity = stops ? wire::Severity::kCritical : wire::Severity::kInfo,
            .reaction = reaction};
  }
  Verdict say(Duration at, wire::Reaction reaction, Duration ahead = 0ms) {
    return book_.take(report(at + ahead, reaction), Time(100s) + at);
  }
  Verdict say_signed(Duration at, wire::Reaction reaction, Duration ahead = 0ms) {
    return book_.take_signed(report(at + ahead, reaction), Time(100s) + at);
  }
  void frame(Duration at, wire::Health health) { book_.note_frame(health, Time(100s) + at); }
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
    if (ahead >= 300ms) {  // networks turn round what is less
      EXPECT_GT(book_.lies(), 0U) << ahead.count();
    }
  }
}

TEST_F(Healths, WhatTheNetworkTurnsRoundIsNoLie) {
  for (Duration at = 10s; at < 20s; at += 300ms) {
    good(at + 20ms);
    EXPECT_EQ(good(at + 130ms, -120ms), Verdict::kLate);
  }
  EXPECT_EQ(book_.lies(), 0U);
}

// Each frame tells how the sensor is. What is reported goes beside it, all of it up to once a
// second.
TEST_F(Healths, WhoSaysStopWhileFramesAreGoodIsTold) {
  for (const Duration pause : {300ms, 600ms, 1150ms}) {
    book_ = {};
    for (Duration at = 10s; at < 22s; at += 10ms) {
      if (at % 1s == 0ms) {
        good(at);
      }
      if (at > 11s && at % pause == 0ms) {
        stop(at);
      }
      if (at % 30ms == 0ms) {
        frame(at, wire::Health::kOk);
      }
    }
    EXPECT_GT(book_.lies(), 0U) << pause.count();
  }
}

// A plug that is loose: what is reported comes late, or never.
TEST_F(Healths, WhatComesAndGoesIsNoLie) {
  std::mt19937 random(1);  // NOLINT: the same in each run
  for (int run = 0; run < 200; ++run) {
    book_ = {};
    bool bad = false;
    std::multimap<Duration, std::function<void(Duration)>> arrivals;
    for (Duration at = 10s; at < 30s; at += 10ms) {
      const bool changes = random() % 50 == 0;
      bad = bad != changes;
      if ((changes || at % 1s == 0ms) && random() % 10 != 0) {
        arrivals.emplace(at + milliseconds(random() % 240), [this, bad, at](Duration now) {
          say(now, bad ? wire::Reaction::kStop : wire::Reaction{}, at - now);
        });
      }
      if (at % 30ms == 0ms) {
        arrivals.emplace(at + milliseconds(random() % 240), [this, bad](Duration now) {
          frame(now, bad ? wire::Health::kFault : wire::Health::kOk);
        });
      }
    }
    for (const auto& [at, arrive] : arrivals) {
      arrive(at);
    }
    EXPECT_EQ(book_.lies(), 0U) << run;
  }
}

// Nobody else can have said it, so it may come and go as it likes, and late.
TEST_F(Healths, WhatIsSignedCountsByItsUptimeAlone) {
  for (Duration at = 10s; at < 20s; at += 500ms) {
    EXPECT_EQ(say_signed(at, wire::Reaction::kStop), Verdict::kTaken);
    EXPECT_TRUE(stops());
    EXPECT_EQ(say_signed(at + 100ms, wire::Reaction{}, 100ms), Verdict::kTaken);
    EXPECT_EQ(say_signed(at + 400ms, wire::Reaction::kStop, -350ms), Verdict::kLate);
    EXPECT_FALSE(stops());
    frame(at + 450ms, wire::Health::kOk);
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
