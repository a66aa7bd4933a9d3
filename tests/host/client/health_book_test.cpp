#include "host/client/session/health_book.h"

#include <chrono>
#include <functional>
#include <map>
#include <random>
#include <utility>

#include <gtest/gtest.h>

namespace stof::client {
namespace {

using namespace std::chrono_literals;
using std::chrono::milliseconds;
using Verdict = HealthBook::Verdict;

constexpr std::uint8_t kBlind = 22;  // the condition of all that stops a robot here

// A sensor's clock and this machine's run alike; uptimes are milliseconds after the start. No
// report tells an event, but for those of the tests of events.
class Healths : public testing::Test {
 protected:
  static wire::HealthReport report(Duration uptime, wire::Reaction reaction,
                                   std::uint32_t events = 0) {
    const auto count = std::chrono::duration_cast<milliseconds>(uptime).count();
    const bool stops = reaction == wire::Reaction::kStop;
    return {.uptime_ms = static_cast<std::uint64_t>(count),
            .active = stops ? 1U << kBlind : 0U,
            .severity = stops ? wire::Severity::kCritical : wire::Severity::kInfo,
            .reaction = reaction,
            .events = events};
  }
  void tell(Duration at, wire::Reaction reaction, std::uint32_t events, Duration ahead = 0ms) {
    book_.take(report(at + ahead, reaction, events), Time(100s) + at);
  }
  void event(Duration at, bool begins, std::uint32_t sequence) {
    book_.note_event({.sequence = sequence,
                      .condition = kBlind,
                      .active = static_cast<std::uint8_t>(begins ? 1 : 0)},
                     Time(100s) + at);
  }
  Verdict say(Duration at, wire::Reaction reaction, Duration ahead = 0ms) {
    return book_.take(report(at + ahead, reaction), Time(100s) + at);
  }
  Verdict say_signed(Duration at, wire::Reaction reaction, Duration ahead = 0ms) {
    return book_.take_signed(report(at + ahead, reaction), Time(100s) + at);
  }
  Verdict good(Duration at, Duration ahead = 0ms) { return say(at, wire::Reaction{}, ahead); }
  Verdict stop(Duration at) { return say(at, wire::Reaction::kStop); }
  bool stops() const { return book_.current()->reaction == wire::Reaction::kStop; }

  HealthBook book_;
};

// Its clock stood, the sensor's did not.
TEST_F(Healths, AMachineThatSleptBelievesTheNextReport) {
  good(10s);
  EXPECT_EQ(good(10500ms, 20s), Verdict::kImplausible);
  book_.slept(20s);
  EXPECT_EQ(good(10600ms, 20s), Verdict::kTaken);
  EXPECT_EQ(book_.lies(), 0U);
}

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

// The sensor's next report tells it, whatever somebody says and whichever event he names.
TEST_F(Healths, WhoSaysAnythingElseThanTheSensorIsToldWithinASecond) {
  for (const bool truth : {false, true}) {
    for (const std::uint32_t named : {0U, 6U, 7U, 8U, 1000U}) {
      for (const Duration ahead : {0ms, 200ms, 1500ms}) {
        book_ = {};
        const auto said = [](bool stops) {
          return stops ? wire::Reaction::kStop : wire::Reaction{};
        };
        for (Duration at = 10s; at < 13s; at += 1s) {
          tell(at, said(truth), 7);
        }
        EXPECT_EQ(book_.lies(), 0U);
        tell(12100ms, said(!truth), named, ahead);
        tell(13s, said(truth), 7);
        tell(14s, said(truth), 7);
        EXPECT_GT(book_.lies(), 0U) << truth << named << ' ' << ahead.count();
      }
    }
  }
}

// Of the same severity, too.
TEST_F(Healths, AnotherConditionOfTheSameEventIsALie) {
  wire::HealthReport one = report(10s, wire::Reaction::kStop, 7);
  book_.take(one, Time(100s));
  one.uptime_ms += 500;
  one.active = 1;
  book_.take(one, Time(100s) + 500ms);
  EXPECT_EQ(book_.lies(), 1U);
}

TEST_F(Healths, AnEventThatTheSensorDoesNotNameIsTold) {
  tell(10s, wire::Reaction::kStop, 7);
  event(10100ms, false, 8);                 // it is over, somebody says
  tell(10300ms, wire::Reaction::kStop, 7);  // which the network may have turned round
  EXPECT_EQ(book_.lies(), 0U);
  tell(11s, wire::Reaction::kStop, 7);
  EXPECT_EQ(book_.lies(), 1U);
  tell(12s, wire::Reaction::kStop, 7);  // told once
  EXPECT_EQ(book_.lies(), 1U);
}

TEST_F(Healths, AnEventThatTheReportContradictsIsTold) {
  event(10s, false, 7);
  tell(10010ms, wire::Reaction::kStop, 7);
  EXPECT_EQ(book_.lies(), 1U);
}

// A plug that is loose: what is told of it comes late, or never.
TEST_F(Healths, WhatComesAndGoesIsNoLie) {
  std::mt19937 random(1);  // NOLINT: the same in each run
  for (int run = 0; run < 200; ++run) {
    book_ = {};
    bool bad = false;
    std::uint32_t events = run < 100 ? 1 : ~0U - 10;  // the number wraps, and is never 0
    std::multimap<Duration, std::function<void(Duration)>> arrivals;
    const auto arrives = [&](Duration at, std::function<void(Duration)> arrive) {
      if (random() % 10 != 0) {
        arrivals.emplace(at + milliseconds(random() % 240), std::move(arrive));
      }
    };
    for (Duration at = 10s; at < 30s; at += 10ms) {
      const bool changes = random() % 50 == 0;
      bad = bad != changes;
      if (changes) {
        events = events == ~0U ? 1 : events + 1;
        arrives(at, [=, this](Duration now) { event(now, bad, events); });
      }
      if (changes || at % 1s == 0ms) {
        arrives(at, [=, this](Duration now) {
          tell(now, bad ? wire::Reaction::kStop : wire::Reaction{}, events, at - now);
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
