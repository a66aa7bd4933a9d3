#include "host/cli/sensor/stream_figures.h"

#include <gtest/gtest.h>

namespace stof::host {
namespace {

client::Frame frame_of(std::uint32_t session, std::int64_t stamp_ns) {
  client::Frame frame;
  frame.origin.session_id = session;
  frame.stamp.exposure_middle_ns = stamp_ns;
  frame.stamp.clock = wire::ClockState::kEmulated;
  return frame;
}

TEST(StreamFigures, OfNothingAreAbsentAndNotZero) {
  const StreamFigures none;
  EXPECT_EQ(none.frames(), 0U);
  EXPECT_FALSE(none.rate_hz());
  EXPECT_FALSE(none.interval_ms());
  EXPECT_FALSE(none.coverage());
  EXPECT_EQ(spread_json(none.latency_ms()), nlohmann::ordered_json(nullptr));
  EXPECT_EQ(spread_text(none.latency_ms()), "-");
}

TEST(StreamFigures, RateAndJitterAreThoseOfTheArrivals) {
  StreamFigures figures;
  for (const double arrived : {10.0, 10.1, 10.2, 10.5}) {
    figures.take(frame_of(1, 0), arrived);
  }
  EXPECT_NEAR(*figures.rate_hz(), 6.0, 1e-9);
  EXPECT_NEAR(figures.interval_ms()->mean, 500.0 / 3, 1e-9);
  EXPECT_NEAR(figures.interval_ms()->median, 100, 1e-9);
  EXPECT_NEAR(figures.interval_ms()->longest, 300, 1e-9);
  EXPECT_FALSE(figures.latency_ms());  // the clock is an emulated one
}

TEST(StreamFigures, WhatTheSensorDidNotMeasureIsNoNumber) {
  StreamFigures figures;
  client::Frame frame = frame_of(1, 0);
  frame.info.emplace();
  figures.take(frame, 10);
  EXPECT_FALSE(figures.sensor_latency_ms());
  EXPECT_FALSE(figures.compute_ms());
  frame.info->latency_ns = 2'000'000;
  frame.info->compute_ns = 1'000'000;
  figures.take(frame, 10.1);
  EXPECT_EQ(figures.sensor_latency_ms()->mean, 2);
  EXPECT_EQ(figures.compute_ms()->mean, 1);
}

TEST(StreamFigures, NothingIsMeasuredFromOneStreamToTheNext) {
  StreamFigures figures;
  for (int time = 0; time < 2; ++time) {  // the same recording, twice
    figures.begin_anew();
    for (int k = 0; k < 11; ++k) {
      figures.take(frame_of(1, k * 100'000'000LL), 10 + k * 0.1);
    }
  }
  EXPECT_EQ(figures.frames(), 22U);
  EXPECT_NEAR(figures.seconds(), 2.0, 1e-9);
  EXPECT_NEAR(*figures.rate_hz(), 10.0, 1e-9);
  EXPECT_NEAR(figures.interval_ms()->mean, 100, 1e-6);
  EXPECT_EQ(figures.stamps_back(), 0U);
}

// Chunks of a file that somebody has put the other way round.
TEST(StreamFigures, NothingIsMeasuredToAFrameThatCameBefore) {
  StreamFigures figures;
  for (const double arrived : {12.0, 12.1, 12.2, 11.0, 11.1, 11.2, 10.0, 10.1}) {
    figures.take(frame_of(1, 0), arrived);
  }
  EXPECT_EQ(figures.arrivals_back(), 2U);
  EXPECT_NEAR(figures.seconds(), 0.5, 1e-9);
  EXPECT_NEAR(*figures.rate_hz(), 10.0, 1e-9);
  EXPECT_NEAR(figures.interval_ms()->longest, 100, 1e-6);
}

TEST(StreamFigures, AFirstFrameAloneHasNoRate) {
  StreamFigures figures;
  figures.take(frame_of(1, 0), 10);
  EXPECT_FALSE(figures.rate_hz());
  EXPECT_EQ(figures.seconds(), 0);
}

TEST(StreamFigures, StampsThatGoBackAreCountedWithinASession) {
  StreamFigures figures;
  figures.take(frame_of(1, 500), 1);
  figures.take(frame_of(1, 400), 2);
  figures.take(frame_of(2, 100), 3);  // started again
  figures.take(frame_of(2, 200), 4);
  EXPECT_EQ(figures.stamps_back(), 1U);
}

TEST(StatisticsJson, HasEachCauseOnce) {
  client::Statistics statistics;
  statistics.frames_lost = 3;
  statistics.bad_crc = 4;
  const nlohmann::ordered_json json = statistics_json(statistics);
  EXPECT_EQ(json["frames"]["lost"], 3);
  EXPECT_EQ(json["packets"]["bad_crc"], 4);
  EXPECT_EQ(json["frames"].size(), 6U);
  EXPECT_EQ(json["packets"].size(), 19U);
}

}  // namespace
}  // namespace stof::host
