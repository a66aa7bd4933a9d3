#include <algorithm>

#include <gtest/gtest.h>

#include "tests/firmware/rig.h"

namespace stof::firmware::test {
namespace {

constexpr hal::Duration kPeriod = 33ms;

// A link that takes its time: what a slow processor looks like to the schedule.
class SlowLink final : public hal::Link {
 public:
  explicit SlowLink(hal::Clock*& clock) : clock_(clock) {}
  Status send(std::span<const std::byte> datagram) noexcept override {
    clock_->wait_until(clock_->now() + took);
    sent += datagram.size();
    return status;
  }

  hal::Duration took{};
  Status status = Status::kOk;
  std::size_t sent = 0;

 private:
  hal::Clock*& clock_;
};

struct SlowRig {
  hal::Clock* clock = nullptr;
  SlowLink link{clock};
  Rig rig;

  SlowRig() : rig(RigOptions{.link = &link}) { clock = &rig.clock; }
};

TEST(Schedule, KeepsThePeriodExactly) {
  Rig rig;
  Receiver receiver;
  run(rig, receiver, 300);
  ASSERT_EQ(rig.log.edges.size(), 300U);
  for (std::size_t i = 0; i < 300; ++i) {
    ASSERT_EQ(rig.log.edges[i], rig.log.edges[0] + static_cast<int>(i) * kPeriod);
  }
  EXPECT_EQ(receiver.frames.size(), 299U);
  EXPECT_EQ(rig.events.counters.skipped_periods, 0U);
  EXPECT_EQ(rig.events.counters.unpaired_edges, 0U);
}

TEST(Schedule, EveryWaitEndsAtTheNextEdge) {
  Rig rig({.faults = {.stereo = {emu::Fault{.kind = emu::FaultKind::kDrop, .call = 0, .every = 2}},
                      .pmd = {emu::Fault{.kind = emu::FaultKind::kDrop, .call = 0, .every = 3}}}});
  for (int i = 0; i < 30; ++i) {
    static_cast<void>(rig.loop.step());
    const hal::Time next = rig.log.edges.back() + kPeriod;
    EXPECT_EQ(std::max(rig.painted_stereo.latest_deadline, rig.painted_pmd.latest_deadline), next);
    EXPECT_LE(rig.clock.now(), next);
  }
  EXPECT_EQ(rig.log.edges.back() - rig.log.edges.front(), 29 * kPeriod);
}

TEST(Schedule, ALateLoopSkipsWholePeriodsAndCountsThem) {
  SlowRig slow;
  for (int i = 0; i < 3; ++i) {
    static_cast<void>(slow.rig.loop.step());
  }
  slow.link.took = 8ms;  // six packets: longer than a period
  for (int i = 0; i < 20; ++i) {
    static_cast<void>(slow.rig.loop.step());
  }
  const std::vector<hal::Time>& edges = slow.rig.log.edges;
  for (std::size_t i = 1; i < edges.size(); ++i) {
    EXPECT_EQ((edges[i] - edges[0]) % kPeriod, 0ms) << "edge " << i << " left the grid";
    EXPECT_GE(edges[i] - edges[i - 1], kPeriod);
  }
  const auto periods = static_cast<std::uint64_t>((edges.back() - edges.front()) / kPeriod);
  EXPECT_EQ(slow.rig.events.counters.skipped_periods, periods + 1 - edges.size());
  EXPECT_GT(slow.rig.events.counters.skipped_periods, 0U);
  EXPECT_GT(slow.rig.events.counters.published, 15U);
  int late = 0;
  while (const auto event = slow.rig.events.take()) {
    late += event->kind == EventKind::kLate ? 1 : 0;
  }
  EXPECT_EQ(late, 1) << "one event for the state, not one an edge";
}

TEST(Schedule, AFewMillisecondsLateKeepTheGridWithoutASkip) {
  Rig rig;
  static_cast<void>(rig.loop.step());
  for (int i = 1; i < 20; ++i) {
    rig.clock.wait_until(rig.log.edges.front() + i * kPeriod + 4ms);
    static_cast<void>(rig.loop.step());
  }
  EXPECT_EQ(rig.log.edges.size(), 20U);
  EXPECT_EQ(rig.events.counters.late_edges, 19U);
  EXPECT_EQ(rig.events.counters.skipped_periods, 0U);
  EXPECT_EQ(rig.events.counters.published, 19U);
}

TEST(Schedule, WhatALongStallLeftBehindIsNotPublished) {
  Rig rig;
  Receiver receiver;
  run(rig, receiver, 5);
  rig.clock.wait_until(rig.clock.now() + 10s);
  run(rig, receiver, 5);
  EXPECT_EQ(rig.events.counters.expired, 1U);
  EXPECT_EQ(receiver.frames.size(), 8U);
  for (const auto& [number, frame] : receiver.frames) {
    EXPECT_LE(hal::Duration(frame.info.latency_ns), 3 * kPeriod);
  }
  EXPECT_EQ((rig.log.edges.back() - rig.log.edges.front()) % kPeriod, 0ms);
}

TEST(Schedule, PacketsLeaveWithinSixtyPercentOfThePeriod) {
  struct TimedLink final : hal::Link {
    hal::Clock* clock = nullptr;
    std::vector<hal::Time> times;
    Status send(std::span<const std::byte>) noexcept override {
      times.push_back(clock->now());
      return Status::kOk;
    }
  } link;
  emu::Clock clock;
  link.clock = &clock;
  PacedLink paced(clock, link);
  const hal::Time start = clock.now();
  paced.begin(100, start + 20ms);
  for (int i = 0; i < 110; ++i) {
    EXPECT_EQ(paced.send({}), Status::kOk);
  }
  EXPECT_LE(link.times.back(), start + 20ms);
  EXPECT_GE(link.times[99], start + 18ms);
  for (std::size_t i = PacedLink::kBurst; i < 100; ++i) {
    EXPECT_GT(link.times[i], link.times[i - PacedLink::kBurst]) << "more than a burst at once";
  }
  paced.begin(100, start);  // has passed: at once
  const hal::Time before = clock.now();
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(paced.send({}), Status::kOk);
  }
  EXPECT_EQ(clock.now(), before);
}

TEST(Schedule, AFullOrUnreachableLinkDropsAndCountsAndNeverDelays) {
  for (const Status status : {Status::kWouldBlock, Status::kDeviceError, Status::kDeviceLost}) {
    SlowRig slow;
    slow.link.status = status;
    int lost = 0;
    for (int i = 0; i < 20; ++i) {
      lost += slow.rig.loop.step() == Status::kDeviceLost ? 1 : 0;
    }
    EXPECT_EQ(slow.rig.log.edges.back() - slow.rig.log.edges.front(), 19 * kPeriod);
    EXPECT_EQ(slow.rig.events.counters.published, 19U);
    EXPECT_EQ(slow.rig.events.counters.packets_sent, 0U);
    EXPECT_GT(slow.rig.events.counters.packets_dropped, 19U);
    EXPECT_EQ(lost, status == Status::kDeviceLost ? 19 : 0);
  }
}

TEST(Schedule, TheCalibrationGoesOutOnceASecond) {
  Rig rig;
  Receiver receiver;
  run(rig, receiver, 152);  // 5 s
  EXPECT_EQ(receiver.calibrations, 5U);
}

TEST(Schedule, FrameInfoTellsWhatTheLoopCounted) {
  Rig rig({.faults = {.stereo = {emu::Fault{.kind = emu::FaultKind::kTear, .call = 3}}}});
  Receiver receiver;
  run(rig, receiver, 10);
  const wire::FrameInfo& last = receiver.frames.rbegin()->second.info;
  EXPECT_EQ(last.counters.frames_published, receiver.frames.size());
  EXPECT_EQ(last.counters.edges, 10U);
  EXPECT_EQ(last.counters.mispaired, 1U);
  EXPECT_TRUE(last.pmd_present);
  EXPECT_GT(last.latency_ns, 0);
  std::size_t pixels = 0;
  for (const std::uint32_t count : last.pixels_by_source) {
    pixels += count;
  }
  EXPECT_EQ(pixels, std::size_t{kWidth} * kHeight);
}

TEST(TimingProblem, NamesTimingsThatCannotWork) {
  EXPECT_STREQ(problem(timing()), "");
  const auto with = [](auto&& change) {
    board::TimingConfig changed = timing();
    change(changed);
    return std::string(problem(changed));
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
}  // namespace stof::firmware::test
