#include "firmware/loop/schedule.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include <gtest/gtest.h>

namespace stof::firmware {
namespace {

using namespace std::chrono_literals;

constexpr hal::Duration kPeriod = 32ms;
constexpr hal::Time kStart{1000s};
constexpr board::TimingConfig kTiming{.period = kPeriod,
                                      .stereo_exposure = 4ms,
                                      .pmd_integration = 16ms,
                                      .edge_tolerance = 200us,
                                      .pmd_every = 1};
constexpr Schedule::Costs kCheap{.search = 5ms, .other = 5ms};

// Sends the frame of an edge, `took` after it; the next edge is a period later.
void send(Schedule& schedule, hal::Duration took, const Schedule::Costs& costs = kCheap) {
  const hal::Time edge = schedule.advance();
  schedule.note_sent(edge, costs, edge + took);
}

TEST(DecayPeak, RisesAtOnceAndFallsByASixteenth) {
  hal::Duration peak = 10ms;
  decay_peak(peak, 26ms);
  EXPECT_EQ(peak, 26ms);
  decay_peak(peak, 10ms);
  EXPECT_EQ(peak, 25ms);
}

TEST(Schedule, TheFirstEdgeIsDueAtOnceAndTheNextAPeriodLater) {
  Schedule schedule(kTiming, true, kStart);
  EXPECT_EQ(schedule.next(), kStart);
  EXPECT_EQ(schedule.advance(), kStart);
  EXPECT_EQ(schedule.next(), kStart + kPeriod);
  EXPECT_EQ(schedule.send_deadline(), kStart + kPeriod * 7 / 8);
}

TEST(Schedule, ALittleLateKeepsTheEdge) {
  Schedule schedule(kTiming, true, kStart);
  const auto arrive = [&](hal::Duration late) { return schedule.arrive(kStart + late); };
  EXPECT_FALSE(arrive(-10ms).noticeable);
  EXPECT_FALSE(arrive(200us).noticeable);
  EXPECT_TRUE(arrive(200us + 1ns).noticeable);
  EXPECT_EQ(arrive(4ms).skipped, 0U);
  EXPECT_EQ(schedule.next(), kStart);
}

TEST(Schedule, MoreThanAnEighthLateSkipsToTheNextPointOfTheGrid) {
  for (const auto& [late, skipped] : {std::pair{hal::Duration(4ms + 1ns), 1},
                                      {32ms, 1},
                                      {hal::Duration(32ms + 1ns), 2},
                                      {320ms, 10}}) {
    Schedule schedule(kTiming, true, kStart);
    const Schedule::Lateness lateness = schedule.arrive(kStart + late);
    EXPECT_EQ(lateness.skipped, static_cast<std::uint64_t>(skipped));
    EXPECT_FALSE(lateness.noticeable);
    EXPECT_EQ(schedule.next(), kStart + skipped * kPeriod);
  }
}

TEST(Schedule, NoEdgeFollowsAnotherSoonerThanSevenEighths) {
  for (const auto& [late, skipped] :
       {std::pair{hal::Duration(4ms), 0}, {hal::Duration(4ms + 1ns), 1}, {70ms, 3}}) {
    Schedule schedule(kTiming, true, kStart);
    const hal::Time planned = schedule.advance();
    EXPECT_EQ(schedule.keep_distance(planned + late), static_cast<std::uint64_t>(skipped));
    EXPECT_EQ(schedule.next(), kStart + (1 + skipped) * kPeriod);
  }
}

TEST(Schedule, AFrameExpiresAfterThreePeriods) {
  const Schedule schedule(kTiming, true, kStart);
  EXPECT_FALSE(schedule.expired(kStart, kStart + 3 * kPeriod));
  EXPECT_TRUE(schedule.expired(kStart, kStart + 3 * kPeriod + 1ns));
}

TEST(Schedule, ThreeEdgesWithoutAFrameAreAGap) {
  const Schedule schedule(kTiming, true, kStart);
  for (const hal::Duration jitter : {-4ms, 0ms, 4ms}) {
    EXPECT_FALSE(schedule.gap(kStart, kStart + 3 * kPeriod + jitter));
    EXPECT_TRUE(schedule.gap(kStart, kStart + 4 * kPeriod + jitter));
  }
}

TEST(Schedule, SamePeriodFollowsFromWhatTheFirstFrameCost) {
  struct Case {
    Schedule::Costs costs;
    bool has_pmd;
    bool same_period;
  };
  // 30 ms of the period are there. Exposure 4 ms, integration 16 ms.
  for (const Case& c : {Case{{.search = 12ms, .other = 14ms}, true, true},
                        Case{{.search = 12ms, .other = 14ms + 1us}, true, false},
                        Case{{.search = 13ms, .other = 14ms}, true, false},
                        Case{{.search = 13ms, .other = 13ms}, false, true},
                        Case{{.search = 1ms, .other = 25ms}, false, true},
                        Case{{.search = 7ms, .other = 7ms, .search_first = false}, true, true},
                        Case{{.search = 7ms, .other = 8ms, .search_first = false}, true, false}}) {
    Schedule schedule(kTiming, c.has_pmd, kStart);
    send(schedule, 40ms, c.costs);
    EXPECT_EQ(schedule.same_period(), c.same_period);
  }
}

// 5 ms each for search and the rest; the frame before went out in the period of the edge after it.
TEST(Schedule, WhereTheRestOfThePeriodIsTooShortTheChangeLeavesOutOneEdgeAndNothingIsLate) {
  for (const auto& [took, left_out] : {std::pair{hal::Duration(22ms), 0}, {22ms + 1us, 1}}) {
    Schedule schedule(kTiming, true, kStart);
    const hal::Time first = schedule.advance();
    const hal::Time second = schedule.advance();
    schedule.note_sent(first, kCheap, second + took);
    ASSERT_TRUE(schedule.same_period());
    EXPECT_EQ(schedule.next(), second + (1 + left_out) * kPeriod);
    EXPECT_EQ(schedule.arrive(second + took + 10ms).skipped, 0U);
    EXPECT_EQ(schedule.advance(), second + (1 + left_out) * kPeriod);
  }
}

TEST(Schedule, WhatTheDriversTakeCountsWhereNothingWasWaitedFor) {
  for (const hal::Duration asked : {16ms, 17ms}) {
    Schedule schedule(kTiming, true, kStart);
    schedule.note_fetch(kStart, kStart + asked, kStart + asked + 20ms);
    send(schedule, 40ms);
    EXPECT_EQ(schedule.same_period(), asked == 16ms);
  }
}

TEST(Schedule, ThreeOverrunsCloseToEachOtherEndItForTwoSeconds) {
  Schedule schedule(kTiming, true, kStart);
  send(schedule, 20ms);
  ASSERT_TRUE(schedule.same_period());
  send(schedule, 33ms);
  send(schedule, 33ms);
  ASSERT_TRUE(schedule.same_period());
  send(schedule, 33ms);
  ASSERT_FALSE(schedule.same_period());
  const hal::Time ended = schedule.next();
  while (!schedule.same_period()) {
    send(schedule, 20ms);
  }
  EXPECT_NEAR(static_cast<double>((schedule.next() - ended) / 1ms), 2000, 64);
}

TEST(Schedule, OverrunsFarFromEachOtherAreForgottenAndSoAreWaitsOfPacing) {
  Schedule schedule(kTiming, true, kStart);
  send(schedule, 20ms);
  for (int i = 0; i < 200; ++i) {
    send(schedule, i % 20 == 0 ? 33ms : 20ms);
    send(schedule, 33ms, {.search = 5ms, .other = 5ms, .paced = 1ms});
  }
  EXPECT_TRUE(schedule.same_period());
}

TEST(Schedule, TheBackOffDoublesToAMinute) {
  Schedule schedule(kTiming, true, kStart);
  hal::Duration expected = 2s;
  for (int i = 0; i < 8; ++i) {
    while (!schedule.same_period()) {
      send(schedule, 20ms);
    }
    while (schedule.same_period()) {
      send(schedule, 33ms);
    }
    const hal::Time ended = schedule.next();
    while (!schedule.same_period()) {
      send(schedule, 20ms);
    }
    EXPECT_NEAR(static_cast<double>((schedule.next() - ended) / 1ms),
                static_cast<double>(expected / 1ms), 64)
        << i;
    expected = std::min<hal::Duration>(2 * expected, 60s);
  }
}

TEST(Schedule, RestartKnowsNothingOfCostsAndNeverGoesBack) {
  Schedule schedule(kTiming, true, kStart);
  send(schedule, 20ms);
  ASSERT_TRUE(schedule.same_period());
  board::TimingConfig slower = kTiming;
  slower.period = 50ms;
  schedule.restart(slower, kStart);
  EXPECT_FALSE(schedule.same_period());
  EXPECT_EQ(schedule.next(), kStart + kPeriod) << "the grid went back";
  schedule.restart(slower, kStart + 1s);
  EXPECT_EQ(schedule.advance(), kStart + 1s);
  EXPECT_EQ(schedule.next(), kStart + 1s + 50ms);
}

TEST(TimingProblem, NamesTimingsThatCannotWork) {
  EXPECT_STREQ(board::problem(kTiming), "");
  const auto with = [](auto&& change) {
    board::TimingConfig changed = kTiming;
    change(changed);
    return std::string(board::problem(changed));
  };
  EXPECT_NE(with([](auto& t) { t.period = 1ms; }), "");
  EXPECT_NE(with([](auto& t) { t.period = 17ms; }), "") << "shorter than the PMD integration";
  EXPECT_NE(with([](auto& t) { t.pmd_every = 0; }), "");
  EXPECT_NE(with([](auto& t) { t.pmd_every = 9; }), "");
  EXPECT_NE(with([](auto& t) { t.edge_tolerance = 0ms; }), "");
  EXPECT_NE(with([](auto& t) { t.pmd_integration = 80ms; }), "");
  EXPECT_EQ(with([](auto& t) {
              t.pmd_integration = 80ms;
              t.pmd_every = 3;
            }),
            "");
}

}  // namespace
}  // namespace stof::firmware
