#include "firmware/appliance.h"

#include <cstdlib>
#include <memory>

#include <gtest/gtest.h>

#include "tests/firmware/rig.h"

namespace stof::firmware::test {
namespace {

struct Block {
  explicit Block(std::size_t size)
      : memory(static_cast<std::byte*>(std::aligned_alloc(
                   dsp::Arena::kAlign,
                   (size + dsp::Arena::kAlign - 1) / dsp::Arena::kAlign * dsp::Arena::kAlign)),
               &std::free),
        bytes(size) {}
  std::span<std::byte> span() const { return {memory.get(), bytes}; }

  std::unique_ptr<std::byte, decltype(&std::free)> memory;
  std::size_t bytes;
};

Plan small_plan() {
  return {
      .setup = small_setup(true),
      .timing = timing(),
      .stream = {.choice = {.coding = {wire::Coding::kRaw, wire::Coding::kRaw, wire::Coding::kRaw}},
                 .pace_percent = 60,
                 .period = timing().period,
                 .revision = 1},
      .serial = {}};
}

// The appliance in the place of the rig's own loop.
struct Box {
  Rig rig;
  PlanRing plans;
  SubscriberRing receivers;
  Block images{std::size_t{4} << 20};
  Block coded{coded_bytes_needed(small_setup(true))};
  std::vector<std::byte> line = std::vector<std::byte>(SerialSender::kRingBytes);
  ByteRing serial{line};
  Appliance appliance;

  explicit Box(bool with_serial = false)
      : appliance({.board = rig.board,
                   .events = rig.events,
                   .plans = plans,
                   .receivers = receivers,
                   .serial = with_serial ? &serial : nullptr},
                  {.origin = {.device_id = 7, .session_id = 9},
                   .clock = wire::ClockState::kEmulated,
                   .calibration = wire::make_calibration_packet(rig.setup.calibration, 40'000,
                                                                timing().period.count())
                                      .value()},
                  small_plan(), {.images = images.span(), .coded = coded.span()}) {}

  void subscribe(std::uint16_t port) {
    SubscriberList list;
    list.peers[0] = {.address = {}, .port = port};
    list.count = 1;
    ASSERT_TRUE(receivers.push(list));
  }
  Receiver run(int steps) {
    Receiver receiver;
    for (int i = 0; i < steps; ++i) {
      static_cast<void>(appliance.step({}));
      receiver.drain(rig.port);
    }
    return receiver;
  }
};

TEST(Appliance, SendsNothingUntilSomebodySubscribes) {
  Box box;
  EXPECT_TRUE(box.run(5).bytes.empty());
  box.subscribe(1);
  const Receiver receiver = box.run(5);
  EXPECT_EQ(receiver.frames.size(), 5U);
  EXPECT_EQ(receiver.calibrations, 1U) << "with the first frame";
  EXPECT_GE(receiver.healths.size(), 1U) << "at once";
  ASSERT_TRUE(box.receivers.push({}));
  EXPECT_TRUE(box.run(5).bytes.empty());
}

TEST(Appliance, NewSettingsTakeEffectBetweenTwoFrames) {
  Box box;
  box.subscribe(1);
  box.run(5);
  Plan plan = small_plan();
  plan.stream.revision = 2;
  plan.stream.choice.of(wire::Stream::kSource) = wire::Coding::kOff;
  ASSERT_TRUE(box.plans.push(plan));
  const Receiver without = box.run(5);
  EXPECT_EQ(without.frames.size(), 5U);
  for (const auto& [number, frame] : without.frames) {
    EXPECT_TRUE(frame.complete());
    EXPECT_EQ(frame.info.tiles[2], 0);
    EXPECT_EQ(frame.info.settings_revision, 2U);
  }
}

TEST(Appliance, AnotherWayToComputeDepthCostsNoMoreThanAFrame) {
  Box box;
  box.subscribe(1);
  box.run(5);
  Plan plan = small_plan();
  plan.setup.depth.match = dsp::for_depth(*dsp::find_preset("quality"));
  plan.setup.depth.match.disparities = kDisparities;
  plan.stream.revision = 3;
  ASSERT_TRUE(box.plans.push(plan));
  const Receiver after = box.run(10);
  EXPECT_GE(after.frames.size(), 9U);
  EXPECT_EQ(after.frames.rbegin()->second.info.settings_revision, 3U);
  EXPECT_EQ(box.rig.events.counters.skipped_periods, 0U);
  EXPECT_EQ(box.rig.events.counters.unpaired_edges, 0U);
}

TEST(Appliance, AnotherPeriodBeginsAnewWithoutASkip) {
  Box box;
  box.subscribe(1);
  box.run(5);
  Plan plan = small_plan();
  plan.timing.period = 50ms;
  ASSERT_TRUE(box.plans.push(plan));
  const std::size_t before = box.rig.log.edges.size();
  const Receiver after = box.run(10);
  EXPECT_GE(after.frames.size(), 9U);
  for (std::size_t i = before + 1; i < box.rig.log.edges.size(); ++i) {
    EXPECT_EQ(box.rig.log.edges[i] - box.rig.log.edges[i - 1], 50ms);
  }
  EXPECT_EQ(box.rig.events.counters.skipped_periods, 0U);
}

TEST(Appliance, ADestinationThatIsSilentIsToldAndSentToNevertheless) {
  Box box;
  SubscriberList list;
  list.peers[0] = {.address = {}, .port = 1};
  list.count = 1;
  list.refused = true;
  ASSERT_TRUE(box.receivers.push(list));
  EXPECT_EQ(box.run(5).frames.size(), 5U);
  bool told = false;
  while (const auto event = box.rig.events.take()) {
    told = told || event->kind == EventKind::kSendFailed;
  }
  EXPECT_TRUE(told);
}

TEST(Appliance, TheSerialLineGetsItsShare) {
  Box box(true);
  Plan plan = small_plan();
  plan.serial.mode = settings::SerialMode::kStof;
  plan.serial.profile = settings::SerialProfile::kCoarse;
  ASSERT_TRUE(box.plans.push(plan));
  box.run(40);
  EXPECT_GT(box.serial.waiting(), 100U);
  EXPECT_GT(box.appliance.serial().sent, 5U);
}

}  // namespace
}  // namespace stof::firmware::test
