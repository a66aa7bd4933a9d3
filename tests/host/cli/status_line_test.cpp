#include "host/cli/view/status_line.h"

#include <array>

#include <gtest/gtest.h>

#include "firmware/wire/messages/conditions.h"
#include "host/cli/sensor_text.h"

namespace stof::host {
namespace {

using namespace std::chrono_literals;

constexpr client::Time kStart{1000s};

// A frame of four pixels, three with depth, that took 5 ms.
struct SmallFrame {
  std::array<dsp::QuarterMm, 4> depth{4000, 0, 8000, 1};
  client::Frame frame;

  explicit SmallFrame(std::chrono::nanoseconds latency = 5ms) {
    frame.depth = {depth.data(), 2, 2};
    frame.last_packet = kStart + 40ms;
    frame.stamp.exposure_middle_ns =
        std::chrono::nanoseconds(frame.last_packet.time_since_epoch() - latency).count();
  }
};

TEST(LatencyOfAFrame, IsFromTheMiddleOfTheExposureToItsLastPacket) {
  EXPECT_EQ(latency_ms(SmallFrame(7ms).frame), 7);
}

TEST(LatencyOfAFrame, IsUnknownWhereTheClockIsEmulated) {
  SmallFrame small;
  small.frame.stamp.clock = wire::ClockState::kEmulated;
  EXPECT_FALSE(latency_ms(small.frame).has_value());
}

TEST(LatencyOfAFrame, IsUnknownWhereTheStampIsForged) {
  SmallFrame small(7ms);
  for (const std::int64_t forged : {INT64_MIN, INT64_MAX, std::int64_t{-1} << 62}) {
    small.frame.stamp.exposure_middle_ns = forged;
    EXPECT_FALSE(latency_ms(small.frame).has_value()) << forged;
  }
}

TEST(CoverageOfAFrame, IsTheShareOfPixelsWithDepth) {
  EXPECT_EQ(coverage(SmallFrame().frame), 0.75);
  EXPECT_EQ(coverage(client::Frame{}), 0);
}

TEST(DriftText, NamesWhatIsSignificantInItsUnit) {
  wire::FrameInfo info;
  EXPECT_EQ(drift_text(info), "");
  info.drifts[0] = {.value = 1745, .sigma = 175};
  info.drifts[1] = {.value = 9999, .sigma = 1};
  info.drifts[3] = {.value = -320, .sigma = 48};
  info.drift_significant = 0b01001;
  EXPECT_EQ(drift_text(info),
            ", drift: pitch 0.100 +- 0.010 deg, range -20.000 +- 3.000 mm: calibrate the rig anew");
}

TEST(StatusLine, TellsTheSecond) {
  StatusLine meter;
  EXPECT_FALSE(meter.due(kStart + 100s));  // nothing came yet
  for (int i = 1; i <= 60; ++i) {          // every 20 ms, the first after 40 ms
    SmallFrame small{std::chrono::milliseconds(i)};
    small.frame.last_packet += (i - 1) * 20ms;
    small.frame.stamp.exposure_middle_ns += (i - 1) * 20'000'000;
    meter.count(small.frame);
  }
  EXPECT_FALSE(meter.due(kStart + 1039ms));
  EXPECT_TRUE(meter.due(kStart + 1040ms));
  EXPECT_TRUE(meter.pending());
  DepthScore score;
  score.e5 = 0.125;
  score.median_error_m = 0.0123;
  client::Statistics statistics;
  statistics.packets_missing = 3;
  statistics.frames_lost = 2;
  statistics.frames_old = 4;  // never seen either
  statistics.frames_stale = 1;
  EXPECT_EQ(meter.line(kStart + 2040ms, statistics, score),
            "   2.0 s   50.0 frames/s, latency 30.0 / 60.0 ms (p50 / p99), coverage 75.0 %, "
            "error 12.3 mm median, E5 0.125, lost 3 packets 7 frames");
  EXPECT_FALSE(meter.pending());
  EXPECT_EQ(meter.line(kStart + 3040ms, {}, std::nullopt),
            "   3.0 s    0.0 frames/s, lost 0 packets 0 frames");
}

TEST(StatusLine, CountsTheTimeBetweenTwoLinesFramesToo) {
  StatusLine meter;
  SmallFrame small;
  meter.count(small.frame);
  static_cast<void>(meter.line(kStart + 1s, {}, std::nullopt));
  small.frame.last_packet += 500ms;  // one frame in half a second
  meter.count(small.frame);
  EXPECT_NE(meter.line(kStart + 2s, {}, std::nullopt).find("  2.0 frames/s"), std::string::npos);
}

TEST(StatusLine, NamesTheFramesThatStandOnOneSensor) {
  StatusLine meter;
  SmallFrame small;
  small.frame.info = wire::FrameInfo{.pmd_present = 1, .sensors = wire::kBothSensors};
  small.frame.calibration = wire::CalibrationPacket{.pmd_width = 176};
  meter.count(small.frame);
  EXPECT_EQ(meter.line(kStart + 1s, {}, std::nullopt).find("alone"), std::string::npos);
  small.frame.info->sensors = wire::kPmdSensor;
  meter.count(small.frame);
  meter.count(small.frame);
  small.frame.info = wire::FrameInfo{};  // of an older sensor, whose PMD camera took no part
  meter.count(small.frame);
  EXPECT_NE(
      meter.line(kStart + 2s, {}, std::nullopt)
          .find(", 1 frames of the stereo pair alone, 2 frames of the PMD camera alone, lost"),
      std::string::npos);
  EXPECT_EQ(meter.line(kStart + 3s, {}, std::nullopt).find("alone"), std::string::npos);
  small.frame.calibration->pmd_width = 0;  // a rig with one sensor
  meter.count(small.frame);
  EXPECT_EQ(meter.line(kStart + 4s, {}, std::nullopt).find("alone"), std::string::npos);
}

TEST(SummaryLine, SaysThatNothingWasLost) {
  client::Statistics statistics;
  statistics.packets_ok = 900;
  statistics.frames_complete = 30;
  EXPECT_EQ(
      summary_line(statistics),
      "30 frames received, 30 verified whole (every packet there, every CRC right), nothing lost");
}

TEST(SummaryLine, TellsWhatParityMadeGood) {
  client::Statistics statistics;
  statistics.recovered = 12;
  EXPECT_NE(summary_line(statistics).find("), 12 packets made of parity, nothing lost"),
            std::string::npos);
  EXPECT_NE(StatusLine().line(kStart, statistics, std::nullopt).find("recovered 12"),
            std::string::npos);
}

TEST(EventLine, SaysWhatToDo) {
  EXPECT_EQ(
      event_line({.condition = 8, .reaction = wire::Reaction::kWatch, .active = 1}),
      "event: drift began: the rig has drifted from its calibration: calibrate it anew; go on, "
      "and tell whoever maintains the robot");
  EXPECT_EQ(event_line({.condition = 8, .active = 0}), "event: drift ended");
}

TEST(EventLine, SaysWhoChangedTheSettings) {
  const auto changed_by = [](std::uint32_t value, std::uint32_t former = 0) {
    return event_line({.condition = static_cast<std::uint8_t>(wire::Condition::kSettingsChanged),
                       .active = 1,
                       .value = value,
                       .former = former});
  };
  EXPECT_NE(changed_by(0x0A000007).find("(by the address that ends in 10.0.0.7)"),
            std::string::npos);
  EXPECT_NE(changed_by(0).find("(by the serial line)"), std::string::npos);
  EXPECT_NE(changed_by(0, 1).find("(by the serial line; the network is on trial)"),
            std::string::npos);
  EXPECT_NE(changed_by(0, 2).find("(the network is as before: nobody saved its change in time)"),
            std::string::npos);
}

TEST(EventLine, SaysWhichCalibrationCameInPlaceOfWhich) {
  EXPECT_NE(
      event_line({.condition = static_cast<std::uint8_t>(wire::Condition::kCalibrationChanged),
                  .active = 1,
                  .value = 0x12,
                  .former = 0xABCDEF01})
          .find("(00000012 in place of abcdef01)"),
      std::string::npos);
}

TEST(EventLine, SaysWhatCameOfATrial) {
  const auto line = [](std::uint8_t active, std::uint32_t value) {
    return event_line({.condition = static_cast<std::uint8_t>(wire::Condition::kReleaseOnTrial),
                       .reaction = wire::Reaction::kWatch,
                       .active = active,
                       .value = value,
                       .former = 0xAB});
  };
  EXPECT_NE(line(1, 1).find("release 000000ab runs on trial"), std::string::npos);
  EXPECT_EQ(line(0, 2), "event: release 000000ab is confirmed; go on");
  EXPECT_EQ(line(0, 3),
            "event: release 000000ab was not confirmed: the former one runs again; go on, and tell "
            "whoever maintains the robot");
}

TEST(EventLine, OfANewerSensor) {
  EXPECT_EQ(event_line({.condition = 200, .reaction = wire::Reaction::kSlow, .active = 1}),
            "event: condition 200 began; slow down: expect gaps");
  EXPECT_NE(event_line({.condition = 200, .reaction = wire::Reaction{9}, .active = 1})
                .find("bring the robot to a safe stop"),
            std::string::npos);
}

TEST(HealthLine, NamesWhatIsActive) {
  EXPECT_EQ(health_line({.uptime_ms = 12'345,
                         .subscribers = 2,
                         .rate_millihertz = 29'970,
                         .latency_us = 21'040,
                         .longest_latency_us = 33'100}),
            "health: good, up 12 s, 30.0 frames/s, latency 21.0 ms mean 33.1 ms longest, 2 "
            "subscribers");
  const wire::HealthReport ill{.active = (1U << 4) | (1U << 31),
                               .severity = wire::Severity::kMajor,
                               .reaction = wire::Reaction::kSlow};
  EXPECT_EQ(active_text(ill), ", active: late release_on_trial");
  EXPECT_NE(health_line(ill).find("major trouble"), std::string::npos);
  EXPECT_NE(health_line(ill).find("; slow down"), std::string::npos);
}

TEST(HealthLine, HasNoFigureThatIsNotKnownYet) {
  EXPECT_EQ(health_line({.uptime_ms = 900, .subscribers = 1}),
            "health: good, up 0 s, 1 subscriber");
  EXPECT_EQ(health_line({.uptime_ms = 90'000, .subscribers = 1}),
            "health: good, up 90 s, 0.0 frames/s, 1 subscriber");
}

TEST(SummaryLine, NamesEveryCauseOfLoss) {
  using client::Statistics;
  constexpr std::uint64_t Statistics::* kCauses[] = {
      &Statistics::packets_missing, &Statistics::frames_lost,
      &Statistics::frames_stale,    &Statistics::frames_dropped,
      &Statistics::socket_drops,    &Statistics::bad_crc,
      &Statistics::truncated,       &Statistics::bad_length,
      &Statistics::bad_field,       &Statistics::bad_magic,
      &Statistics::bad_version,     &Statistics::unknown,
      &Statistics::oversized,       &Statistics::foreign,
      &Statistics::duplicate,       &Statistics::late,
      &Statistics::events_dropped};
  for (std::uint64_t Statistics::* cause : kCauses) {
    Statistics statistics;
    statistics.*cause = 4711;
    const std::string line = summary_line(statistics);
    EXPECT_NE(line.find("), 4711 "), std::string::npos) << line;
    EXPECT_EQ(line.find("nothing lost"), std::string::npos) << line;
  }
}

}  // namespace
}  // namespace stof::host
