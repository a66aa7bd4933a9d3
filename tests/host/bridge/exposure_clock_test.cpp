#include "host/bridge/exposure_clock.h"

#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace stof::bridge {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kPeriod = 33 * kMs;
constexpr std::int64_t kLatency = 21 * kMs;
constexpr std::int64_t kFastest = 120'000;  // ns that the fastest packet takes
constexpr std::int64_t kRoundTrip = 400'000;

// A sensor whose clock begins anywhere and is wrong by `ppm`, seen by this machine.
class Sensor {
 public:
  explicit Sensor(std::int64_t ppm, std::uint32_t session = 1) : ppm_(ppm), session_(session) {}

  // The frame exposed at `truth`, ns of this machine, whose first packet took `way`.
  ExposureClock::Arrival frame(std::int64_t truth, std::int64_t way) const {
    return {.session = session_,
            .stamp = {.exposure_middle_ns = clock(truth)},
            .latency_ns = clock(truth + kLatency) - clock(truth),
            .at_ns = truth + kLatency + way,
            .round_trip_ns = kRoundTrip};
  }
  std::int64_t clock(std::int64_t truth) const {
    return truth + truth / 1'000'000 * ppm_ - stood_ - 987'654'321'000;
  }
  void stand(std::int64_t ns) { stood_ += ns; }

 private:
  std::int64_t ppm_;
  std::uint32_t session_;
  std::int64_t stood_ = 0;
};

TEST(ExposureClockTest, TruthLiesWithinTheBoundOfEveryStamp) {
  for (const std::int64_t ppm : {-199, -40, 0, 40, 199}) {
    const Sensor sensor(ppm);
    ExposureClock clock;
    std::mt19937 random(5);  // NOLINT: the same numbers in each run
    std::exponential_distribution<double> held(1.0 / 300'000);
    std::int64_t widest = 0;
    for (int k = 0; k < 20'000; ++k) {
      const std::int64_t truth = 5'000 * kMs + k * kPeriod;
      // Only each 50th packet is as fast as can be.
      const std::int64_t way =
          kFastest + (k % 50 == 0 ? 0 : static_cast<std::int64_t>(held(random)));
      const ExposureClock::Exposure found = clock.note(sensor.frame(truth, way));
      ASSERT_TRUE(found.bound_ns);
      ASSERT_GE(found.middle_ns, truth - 20'000) << ppm << " frame " << k;  // drift of the latency
      ASSERT_LE(found.middle_ns - *found.bound_ns, truth) << ppm << " frame " << k;
      widest = std::max(widest, *found.bound_ns);
    }
    EXPECT_LT(widest, 2 * kMs) << ppm;
  }
}

TEST(ExposureClockTest, PacketsThatAreHeldBackMoveNoStamp) {
  const Sensor sensor(0);
  ExposureClock clock;
  clock.note(sensor.frame(1'000 * kMs, kFastest));
  for (int k = 1; k < 20; ++k) {
    const std::int64_t truth = 1'000 * kMs + k * kPeriod;
    const ExposureClock::Exposure found = clock.note(sensor.frame(truth, 60 * kMs));
    EXPECT_NEAR(static_cast<double>(found.middle_ns), static_cast<double>(truth + kFastest),
                200e-6 * static_cast<double>(k * kPeriod + 60 * kMs) + 1000);
  }
}

TEST(ExposureClockTest, FrameWhoseInfoWasLostIsStampedByTheOthers) {
  const Sensor sensor(0);
  ExposureClock clock;
  ExposureClock::Arrival lost = sensor.frame(1'000 * kMs, kFastest);
  lost.latency_ns.reset();
  const ExposureClock::Exposure first = clock.note(lost);
  EXPECT_EQ(first.middle_ns, lost.at_ns) << "nothing is known yet but the arrival";
  EXPECT_FALSE(first.bound_ns);
  clock.note(sensor.frame(1'033 * kMs, kFastest));
  lost = sensor.frame(1'066 * kMs, 900'000);
  lost.latency_ns.reset();
  EXPECT_NEAR(static_cast<double>(clock.note(lost).middle_ns), 1'066e6 + kFastest, 10'000);
}

TEST(ExposureClockTest, AnotherSessionHasAnotherClock) {
  ExposureClock clock;
  clock.note(Sensor(0).frame(1'000 * kMs, kFastest));
  Sensor again(0, 2);
  again.stand(500 * kMs);
  const ExposureClock::Exposure found = clock.note(again.frame(2'000 * kMs, 300'000));
  EXPECT_EQ(found.middle_ns, 2'000 * kMs + 300'000);
}

TEST(ExposureClockTest, ClockThatStoodIsFollowedAfterASecond) {
  Sensor sensor(0);
  ExposureClock clock;
  clock.note(sensor.frame(1'000 * kMs, kFastest));
  sensor.stand(5'000 * kMs);
  std::int64_t truth = 7'000 * kMs;
  ExposureClock::Exposure found;
  for (const std::int64_t end = truth + 1'100 * kMs; truth < end; truth += kPeriod) {
    found = clock.note(sensor.frame(truth, kFastest));
  }
  EXPECT_EQ(found.middle_ns, truth - kPeriod + kFastest);
}

TEST(ExposureClockTest, OtherClocksHaveNoBound) {
  for (const wire::ClockState state : {wire::ClockState::kEmulated, wire::ClockState::kRecorded}) {
    ExposureClock clock;
    ExposureClock::Arrival frame = Sensor(0).frame(1'000 * kMs, kFastest);
    frame.stamp.clock = state;
    const ExposureClock::Exposure found = clock.note(frame);
    EXPECT_EQ(found.middle_ns, frame.at_ns - kLatency);
    EXPECT_FALSE(found.bound_ns);
  }
}

TEST(ExposureClockTest, WithoutARoundTripThereIsNoBound) {
  ExposureClock clock;
  ExposureClock::Arrival frame = Sensor(0).frame(1'000 * kMs, kFastest);
  frame.round_trip_ns.reset();
  EXPECT_FALSE(clock.note(frame).bound_ns);
}

TEST(ExposureClockTest, AnyNumbersAreSafe) {
  using Limit = std::numeric_limits<std::int64_t>;
  ExposureClock clock;
  for (const std::int64_t exposed : {Limit::min(), std::int64_t{0}, Limit::max()}) {
    for (const std::int64_t latency : {Limit::min(), std::int64_t{0}, Limit::max()}) {
      for (const std::int64_t at : {Limit::min(), std::int64_t{0}, Limit::max()}) {
        clock.note({.stamp = {.exposure_middle_ns = exposed},
                    .latency_ns = latency,
                    .at_ns = at,
                    .round_trip_ns = latency});
      }
    }
  }
}

}  // namespace
}  // namespace stof::bridge
