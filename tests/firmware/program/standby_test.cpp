#include "firmware/loop/standby.h"

#include <gtest/gtest.h>

#include "tests/firmware/appliance_rig.h"

namespace stof::firmware {
namespace {

using namespace std::chrono_literals;
using test::ApplianceRig;

constexpr std::uint16_t kPort = 1;

RunConfig with_standby(bool standby = true) {
  RunConfig run_config = test::small_run_config();
  run_config.standby = standby;
  return run_config;
}

// An appliance that may rest, and what its receivers got.
struct Resting {
  ApplianceRig box;
  test::Receiver receiver;
  ControlStatus control;

  explicit Resting(bool with_serial = false) : box(with_serial) {
    EXPECT_TRUE(box.run_configs.push(with_standby()));
  }
  void step() {
    static_cast<void>(box.appliance.step(control));
    receiver.drain(box.rig.port);
  }
  void run(hal::Duration time) {
    for (const hal::Time end = now() + time; now() < end;) {
      step();
    }
  }
  hal::Time now() { return box.rig.clock.now(); }
  std::size_t edges() const { return box.rig.log.edges.size(); }
  void leave() { ASSERT_TRUE(box.receivers.push(ReceiverList{})); }
  bool rests() const { return box.appliance.in_standby(); }
};

TEST(Standby, BeginsTenSecondsAfterTheLastNeed) {
  Standby standby;
  EXPECT_FALSE(standby.update(true, false, hal::Time(5s)));
  EXPECT_FALSE(standby.update(true, false, hal::Time(14'999ms)));
  EXPECT_TRUE(standby.update(true, false, hal::Time(15s)));
  EXPECT_FALSE(standby.update(true, true, hal::Time(20s)));
  EXPECT_FALSE(standby.update(true, false, hal::Time(29'999ms)));
  EXPECT_TRUE(standby.update(true, false, hal::Time(30s)));
  EXPECT_FALSE(standby.update(false, false, hal::Time(99s)));
  EXPECT_FALSE(standby.update(true, false, hal::Time(100s)));
}

TEST(StandbyOfTheAppliance, IsNoneUnlessTheSettingsWantIt) {
  ApplianceRig box;
  const hal::Time end = box.rig.clock.now() + 60s;
  while (box.rig.clock.now() < end) {
    static_cast<void>(box.appliance.step({}));
  }
  EXPECT_FALSE(box.appliance.in_standby());
  EXPECT_GT(box.rig.log.edges.size(), 1500U);
}

TEST(StandbyOfTheAppliance, HasNoEdgesAndNoConditions) {
  Resting sensor;
  sensor.run(11s);
  ASSERT_TRUE(sensor.rests());
  const std::size_t edges = sensor.edges();
  EXPECT_GT(edges, 290U);  // of ten seconds
  hal::Duration longest{};
  for (const hal::Time end = sensor.now() + 3600s; sensor.now() < end;) {
    const hal::Time before = sensor.now();
    sensor.step();
    longest = std::max(longest, sensor.now() - before);
  }
  EXPECT_EQ(sensor.edges(), edges);
  EXPECT_LE(longest, 100ms) << "so long the watchdog is not fed";
  EXPECT_EQ(sensor.box.appliance.publisher().health().summary(), wire::Health::kOk);
  EXPECT_EQ(sensor.box.appliance.publisher().health().rate_millihertz(), 0U);
  EXPECT_EQ(sensor.box.rig.events.counters.skipped_periods, 0U);
  EXPECT_EQ(sensor.box.rig.events.counters.unpaired_edges, 0U);
}

TEST(StandbyOfTheAppliance, EndsWithTheFirstFrameWithin300Milliseconds) {
  Resting sensor;
  sensor.run(11s);
  for (const hal::Duration rest : {hal::Duration(20ms), hal::Duration(7s), hal::Duration(3600s)}) {
    sensor.run(10s + rest);
    ASSERT_TRUE(sensor.rests());
    const std::size_t edges = sensor.edges();
    const std::size_t frames = sensor.receiver.frames.size();
    sensor.box.subscribe(kPort);
    const hal::Time asked = sensor.now();
    while (sensor.receiver.frames.size() == frames && sensor.now() - asked < 60s) {
      sensor.step();
    }
    EXPECT_LE(sensor.now() - asked, 300ms);
    EXPECT_FALSE(sensor.rests());
    sensor.run(2s);
    // Each is of an edge after the rest.
    const std::vector<std::size_t> seen = test::expect_true_frames(sensor.box.rig, sensor.receiver);
    ASSERT_GT(seen.size(), frames);
    EXPECT_GE(seen[frames], edges);
    EXPECT_EQ(sensor.receiver.healths.back().active, 0U);
    sensor.leave();
  }
  EXPECT_TRUE(sensor.receiver.events.empty()) << "a pause that was asked for is no condition";
  EXPECT_EQ(sensor.box.rig.events.counters.skipped_periods, 0U);
  EXPECT_EQ(sensor.box.rig.events.counters.unpaired_edges, 0U);
}

// However short it was.
TEST(StandbyOfTheLoop, DepthIsAveragedAnewAfterIt) {
  test::Rig rig({.still = true, .temporal = true});
  test::Receiver receiver;
  test::run(rig, receiver, 20);
  const auto last = receiver.frames.rbegin();
  ASSERT_GT(last->second.info.steady_frames, 4U);
  const std::uint32_t before = last->first;
  rig.loop.rest_part();
  rig.loop.wake();
  test::run(rig, receiver, 4);
  const auto first = receiver.frames.upper_bound(before);
  ASSERT_NE(first, receiver.frames.end());
  EXPECT_EQ(first->second.info.steady_frames, 1U);
}

TEST(StandbyOfTheAppliance, WaitsForWhoeverNeedsFrames) {
  Resting line(true);
  RunConfig run_config = with_standby();
  run_config.serial.mode = settings::SerialMode::kStof;
  ASSERT_TRUE(line.box.run_configs.push(run_config));
  line.run(30s);
  EXPECT_FALSE(line.rests());

  Resting trial;
  trial.control.keep_awake = true;
  trial.run(30s);
  EXPECT_FALSE(trial.rests());
  trial.control.keep_awake = false;
  trial.run(11s);
  EXPECT_TRUE(trial.rests());
  trial.control.keep_awake = true;
  trial.run(100ms);
  EXPECT_FALSE(trial.rests());
}

TEST(StandbyOfTheAppliance, ASlowSensorKeepsItsPeriodWhenItWakes) {
  Resting sensor;
  RunConfig run_config = with_standby();
  run_config.timing.period = 60s;
  run_config.publisher.period = 60s;
  ASSERT_TRUE(sensor.box.run_configs.push(run_config));
  sensor.run(15s);
  ASSERT_TRUE(sensor.rests());
  sensor.box.subscribe(kPort);
  sensor.run(120s);
  const std::vector<hal::Time>& edges = sensor.box.rig.log.edges;
  ASSERT_GE(edges.size(), 3U);
  for (std::size_t i = 1; i < edges.size(); ++i) {
    EXPECT_GE(edges[i] - edges[i - 1], 52s);
  }
}

}  // namespace
}  // namespace stof::firmware
