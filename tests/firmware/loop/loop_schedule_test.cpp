#include <algorithm>

#include <gtest/gtest.h>

#include "tests/firmware/rig.h"

namespace stof::firmware::test {
namespace {

constexpr hal::Duration kPeriod = 33ms;

// A port that takes its time: what a slow processor looks like to the schedule.
class SlowPort final : public hal::DatagramPort {
 public:
  explicit SlowPort(hal::Clock*& clock) : clock_(clock) {}
  Status send(const hal::Peer&, std::span<const std::span<const std::byte>> datagrams,
              std::size_t& sent) noexcept override {
    for (std::size_t i = 0; i < datagrams.size(); ++i) {
      const bool stalls = times.size() + 1 == stall_at;
      clock_->wait_until(clock_->now() + took + (stalls ? stall : hal::Duration{}));
      times.push_back(clock_->now());
    }
    sent = status == Status::kOk ? datagrams.size() : 0;
    return status;
  }
  Result<hal::Received> receive(std::span<std::byte>, hal::Duration) noexcept override {
    return fail(Status::kTimeout);
  }
  std::uint64_t overruns() const noexcept override { return 0; }
  bool take_unreachable(hal::Peer&) noexcept override { return false; }
  std::uint16_t port() const noexcept override { return 1; }

  hal::Duration took{};      // of each datagram
  std::size_t stall_at = 0;  // the one that takes so much longer; 0: none
  hal::Duration stall{};
  Status status = Status::kOk;
  std::vector<hal::Time> times;

 private:
  hal::Clock*& clock_;
};

struct SlowRig {
  hal::Clock* clock = nullptr;
  SlowPort port{clock};
  Rig rig;

  SlowRig() : rig(RigOptions{.port = &port}) { clock = &rig.clock; }
};

TEST(LoopSchedule, KeepsThePeriodExactly) {
  Rig rig;
  Receiver receiver;
  run(rig, receiver, 300);
  ASSERT_EQ(rig.log.edges.size(), 300U);
  for (std::size_t i = 0; i < 300; ++i) {
    ASSERT_EQ(rig.log.edges[i], rig.log.edges[0] + static_cast<int>(i) * kPeriod);
  }
  EXPECT_EQ(receiver.frames.size(), 300U);
  EXPECT_EQ(rig.events.counters.skipped_periods, 0U);
  EXPECT_EQ(rig.events.counters.unpaired_edges, 0U);
}

// The step that changes to publishing in the frame's own period would publish two.
TEST(LoopSchedule, PublishesNoMoreThanItWasToldTo) {
  Rig rig;
  Receiver receiver;
  rig.loop.end_after(1);
  run(rig, receiver, 10);
  EXPECT_EQ(receiver.frames.size(), 1U);
  EXPECT_EQ(rig.events.counters.published, 1U);
}

TEST(LoopSchedule, EveryWaitEndsAtTheNextEdge) {
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

TEST(LoopSchedule, ALateLoopSkipsWholePeriodsAndCountsThem) {
  SlowRig slow;
  for (int i = 0; i < 3; ++i) {
    static_cast<void>(slow.rig.loop.step());
  }
  slow.port.took = 8ms;  // six packets: longer than a period
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

TEST(LoopSchedule, AFewMillisecondsLateKeepTheGridWithoutASkip) {
  Rig rig;
  static_cast<void>(rig.loop.step());
  for (int i = 1; i < 20; ++i) {
    rig.clock.wait_until(rig.log.edges.front() + i * kPeriod + 4ms);
    static_cast<void>(rig.loop.step());
  }
  EXPECT_EQ(rig.log.edges.size(), 20U);
  EXPECT_EQ(rig.events.counters.late_edges, 19U);
  EXPECT_EQ(rig.events.counters.skipped_periods, 0U);
  EXPECT_EQ(rig.events.counters.published, 20U);
}

TEST(LoopSchedule, WhatALongStallLeftBehindIsNotPublished) {
  SlowRig slow;
  Rig& rig = slow.rig;
  slow.port.took = 3ms;  // frames wait for the period after theirs
  for (int i = 0; i < 5; ++i) {
    static_cast<void>(rig.loop.step());
  }
  rig.clock.wait_until(rig.clock.now() + 10s);
  for (int i = 0; i < 5; ++i) {
    static_cast<void>(rig.loop.step());
  }
  EXPECT_EQ(rig.events.counters.expired, 1U);
  EXPECT_EQ(rig.events.counters.published, 8U);
  EXPECT_EQ((rig.log.edges.back() - rig.log.edges.front()) % kPeriod, 0ms);
}

// A program that was stopped in the middle of a frame and goes on later: what is left of the frame
// shows the past.
TEST(LoopSchedule, AFrameThatGotOldInMidSendIsAbandoned) {
  for (const hal::Duration period : {hal::Duration(33ms), hal::Duration(5s)}) {
    hal::Clock* clock = nullptr;
    SlowPort port(clock);
    const wire::StreamChoice choice{
        .coding = {wire::Coding::kRaw, wire::Coding::kRaw, wire::Coding::kRaw, wire::Coding::kRaw,
                   wire::Coding::kRaw, wire::Coding::kRaw, wire::Coding::kRaw, wire::Coding::kRaw},
        .cloud_step = 2};
    board::TimingConfig slow = timing();
    slow.period = period;
    Rig rig({.timing = slow, .port = &port, .choice = choice});
    clock = &rig.clock;
    rig.publisher.set_params({.choice = choice, .pace_percent = 60, .period = period});
    for (int i = 0; i < 4; ++i) {
      static_cast<void>(rig.loop.step());
    }
    const std::uint64_t expired = rig.events.counters.expired;
    const std::uint64_t dropped = rig.events.counters.packets_dropped;
    port.times.clear();
    port.stall_at = 3;
    port.stall = 9s;
    static_cast<void>(rig.loop.step());
    EXPECT_LE(port.times.size(), 9U) << "calibration, and the burst that was on its way";
    EXPECT_EQ(rig.events.counters.expired, expired + 1);
    EXPECT_GT(rig.events.counters.packets_dropped, dropped);
    port.stall_at = 0;
    for (int i = 0; i < 2; ++i) {
      port.times.clear();
      static_cast<void>(rig.loop.step());
    }
    EXPECT_GT(port.times.size(), 10U) << "the next ones are whole";
  }
}

// The same where it was stopped before the frame's first datagram, while it computed.
TEST(LoopSchedule, AFrameThatIsOldWhenItsSendingBeginsIsAbandoned) {
  hal::Clock* clock = nullptr;
  SlowPort port(clock);
  Rig rig({.port = &port});
  clock = &rig.clock;
  const PublisherParams params{.choice = {.coding = {wire::Coding::kRaw, wire::Coding::kRaw}},
                               .pace_percent = 60,
                               .period = kPeriod};
  for (int i = 0; i < 4; ++i) {
    static_cast<void>(rig.loop.step());
  }
  rig.publisher.set_params(params);  // the calibration goes out before the next frame
  port.times.clear();
  port.stall_at = 1;
  port.stall = 9s;
  static_cast<void>(rig.loop.step());
  EXPECT_EQ(port.times.size(), 1U);
  EXPECT_EQ(rig.events.counters.expired, 1U);
}

// However long the period is: nobody waits for the end of a frame for half a minute.
TEST(LoopSchedule, NoFrameIsSpreadOverMoreThan50Milliseconds) {
  hal::Clock* clock = nullptr;
  SlowPort port(clock);
  board::TimingConfig slow = timing();
  slow.period = 60s;
  Rig rig({.timing = slow, .port = &port});
  clock = &rig.clock;
  rig.publisher.set_params({.choice = {.coding = {wire::Coding::kRaw, wire::Coding::kRaw,
                                                  wire::Coding::kRaw, wire::Coding::kRaw}},
                            .pace_percent = 90,
                            .period = slow.period});
  for (int i = 0; i < 4; ++i) {
    port.times.clear();
    static_cast<void>(rig.loop.step());
  }
  ASSERT_GT(port.times.size(), 2U);
  EXPECT_LE(port.times.back() - port.times.front(), 50ms);
}

// A frame of many packets leaves in bursts, within its share of the period, before the next edge.
TEST(LoopSchedule, PacketsAreSpreadOverTheirShareOfThePeriod) {
  for (const int percent : {0, 20, 60}) {
    SCOPED_TRACE(percent);
    hal::Clock* clock = nullptr;
    SlowPort port(clock);
    Rig rig({.port = &port,
             .choice = {.coding = {wire::Coding::kRaw, wire::Coding::kRaw, wire::Coding::kRaw,
                                   wire::Coding::kRaw, wire::Coding::kRaw, wire::Coding::kRaw,
                                   wire::Coding::kRaw, wire::Coding::kRaw},
                        .cloud_step = 2}});
    clock = &rig.clock;
    rig.publisher.set_params(
        {.choice = {.coding = {wire::Coding::kRaw, wire::Coding::kRaw, wire::Coding::kRaw,
                               wire::Coding::kRaw, wire::Coding::kRaw, wire::Coding::kRaw,
                               wire::Coding::kRaw, wire::Coding::kRaw},
                    .cloud_step = 2},
         .pace_percent = percent,
         .period = kPeriod});
    for (int i = 0; i < 4; ++i) {
      port.times.clear();
      static_cast<void>(rig.loop.step());
    }
    ASSERT_GT(port.times.size(), 10U);
    const hal::Duration spread = port.times.back() - port.times.front();
    EXPECT_LE(spread, kPeriod * percent / 100);
    EXPECT_EQ(spread > hal::Duration{}, percent > 0);
    EXPECT_LE(port.times.back(), rig.log.edges.back() + kPeriod - kPeriod / 8);
  }
}

// Once it is known that a frame can be out before its next edge, it is.
TEST(LoopSchedule, AFrameIsOutBeforeItsNextEdge) {
  Rig rig;
  Receiver receiver;
  run(rig, receiver, 20);
  for (const auto& [number, frame] : receiver.frames) {
    if (number > 0) {
      EXPECT_LT(hal::Duration(frame.info.latency_ns), kPeriod) << number;
    }
  }
}

TEST(LoopSchedule, AFullOrUnreachableLinkDropsAndCountsAndNeverDelays) {
  for (const Status status : {Status::kWouldBlock, Status::kDeviceError, Status::kDeviceLost}) {
    SlowRig slow;
    slow.port.status = status;
    int lost = 0;
    for (int i = 0; i < 20; ++i) {
      lost += slow.rig.loop.step() == Status::kDeviceLost ? 1 : 0;
    }
    EXPECT_EQ(slow.rig.log.edges.back() - slow.rig.log.edges.front(), 19 * kPeriod);
    EXPECT_EQ(slow.rig.events.counters.published, 20U);
    EXPECT_EQ(slow.rig.events.counters.packets_sent, 0U);
    EXPECT_GT(slow.rig.events.counters.packets_dropped, 19U);
    EXPECT_EQ(lost, status == Status::kDeviceLost ? 19 : 0);
  }
}

TEST(LoopSchedule, TheCalibrationGoesOutOnceASecond) {
  Rig rig;
  Receiver receiver;
  run(rig, receiver, 152);  // 5 s
  EXPECT_EQ(receiver.calibrations, 5U);
}

TEST(LoopSchedule, FrameInfoTellsWhatTheLoopCounted) {
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

}  // namespace
}  // namespace stof::firmware::test
