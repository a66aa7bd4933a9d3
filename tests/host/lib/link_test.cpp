// What libstof tells beside frames: health, the link, clocks, raw pictures, pixels of points.
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <stof/stof.h>
#include <stof/stof.hpp>

#include "firmware/wire/messages/health.h"
#include "tests/host/lib/lib_sensor.h"

namespace {

using namespace std::chrono_literals;
using stof::test::all_streams;
using stof::test::calibration;
using stof::test::frame_spec;
using stof::test::open;
using stof::test::send;
using stof::test::subscribe;

TEST(LibHealth, HasTheCountersOfTheWireAndItsAge) {
  stof::test::Sensor sensor;
  stof::Sensor client = open(sensor);
  subscribe(client, sensor);
  stof::wire::HealthReport report{.uptime_ms = 5000};
  report.counters = {.edges = 1,
                     .frames_published = 2,
                     .mispaired = 3,
                     .timeouts = 4,
                     .deadline_misses = 5,
                     .link_drops = 6};
  report.packets_sent = 7;
  report.control = {.accepted = 8,
                    .truncated = 9,
                    .bad_magic = 10,
                    .bad_version = 11,
                    .bad_length = 12,
                    .bad_crc = 13,
                    .bad_field = 14,
                    .not_control = 15,
                    .foreign = 16,
                    .too_short = 17,
                    .cookies = 18,
                    .busy = 19,
                    .overrun = 20,
                    .forged = 21,
                    .replayed = 22};
  report.serial_sent = 23;
  report.serial_dropped = 24;
  report.serial_refused = 25;
  std::array<std::byte, stof::wire::kHealthReportBytes> bytes{};
  stof::wire::encode_health_report(report, bytes);
  send(sensor,
       {stof::test::report_datagram(frame_spec(1), stof::wire::PacketType::kHealth, bytes)});
  for (int i = 0; i < 6000 && !client.health(); ++i) {
    static_cast<void>(client.next(10ms));
  }
  const auto health = client.health();
  ASSERT_TRUE(health);
  const std::array<std::uint64_t, 25> told{
      health->edges,         health->frames_published, health->mispaired,
      health->timeouts,      health->deadline_misses,  health->link_drops,
      health->packets_sent,  health->accepted,         health->truncated,
      health->bad_magic,     health->bad_version,      health->bad_length,
      health->bad_crc,       health->bad_field,        health->not_control,
      health->foreign,       health->too_short,        health->cookies,
      health->busy,          health->overrun,          health->forged,
      health->replayed,      health->serial_sent,      health->serial_dropped,
      health->serial_refused};
  for (std::size_t i = 0; i < told.size(); ++i) {
    EXPECT_EQ(told[i], i + 1);
  }
  EXPECT_GE(health->age_ns, 0);
  std::this_thread::sleep_for(600ms);
  const auto later = client.health();
  ASSERT_TRUE(later);
  EXPECT_GE(later->age_ns, health->age_ns + 600'000'000);
  EXPECT_EQ(later->silent, 1U) << "no frame ever came";
}

TEST(LibLink, TellsSilenceAndARestartAsEvents) {
  auto sensor = std::make_unique<stof::test::Sensor>();
  stof::Sensor client = open(*sensor);
  subscribe(client, *sensor);
  const auto wait_for = [&](std::uint32_t condition) {
    std::optional<stof::LinkEvent> event;
    for (int i = 0; i < 6000 && !(event && event->condition == condition); ++i) {
      static_cast<void>(client.next(10ms));
      event = client.next_link_event();
    }
    return event && event->condition == condition ? event : std::nullopt;
  };
  send(*sensor, {calibration()});
  send(*sensor, all_streams(5));
  const auto silent = wait_for(STOF_LINK_SILENT);
  ASSERT_TRUE(silent);
  EXPECT_EQ(silent->active, 1U);
  EXPECT_GT(silent->at_ns, 0);
  const std::uint16_t number = sensor->number();
  sensor.reset();
  sensor = std::make_unique<stof::test::Sensor>(nullptr, number, /*session=*/2);
  subscribe(client, *sensor);
  send(*sensor, stof::test::datagrams(frame_spec(1)));
  const auto restarted = wait_for(STOF_LINK_RESTARTED);
  ASSERT_TRUE(restarted);
  EXPECT_EQ(restarted->active, 1U);
  EXPECT_EQ(restarted->count, 1U);
  EXPECT_EQ(client.link().restarts, 1U);
  EXPECT_STREQ(stof_link_condition_name(STOF_LINK_RESTARTED), "restarted");
  EXPECT_STREQ(stof_link_condition_name(3), "unknown");
  EXPECT_STREQ(stof_link_condition_name(1U << 31), "unknown");
}

TEST(LibLink, ItsThreadTellsEventsOfTheLink) {
  stof::test::Sensor sensor;
  stof::Sensor client = open(sensor);
  std::atomic<std::uint32_t> told{0};
  ASSERT_EQ(client.start({.frame = {},
                          .health = {},
                          .event = {},
                          .failed = {},
                          .link = [&](const stof::LinkEvent& event) { told = event.condition; }}),
            STOF_OK);
  stof_link_event event = STOF_INIT(stof_link_event);
  EXPECT_EQ(stof_next_link_event(client.c(), &event), STOF_BUSY);
  for (int i = 0; i < 6000 && told == 0; ++i) {
    std::this_thread::sleep_for(10ms);
  }
  EXPECT_EQ(told, STOF_LINK_SILENT);
}

TEST(LibClock, SaysThatEmulatedTimeIsMappedToNone) {
  stof::test::Sensor sensor;
  stof::Sensor client = open(sensor);
  subscribe(client, sensor);
  stof_clock clock = STOF_INIT(stof_clock);
  EXPECT_EQ(stof_get_clock(client.c(), &clock), STOF_NOT_YET);
  send(sensor, all_streams(5));
  const auto frame = client.next(10s);
  ASSERT_TRUE(frame);
  EXPECT_EQ(stof_get_clock(client.c(), &clock), STOF_UNSUPPORTED);
  EXPECT_FALSE(frame->exposure_here());
  stof_clock none{};
  EXPECT_EQ(stof_get_clock(client.c(), &none), STOF_BAD_ARGUMENT);
}

// The stamps of a sensor on this machine, whose clock is this one's.
TEST(LibClock, MapsTheSensorsClockToThisMachines) {
  stof::test::Sensor sensor;
  stof::Sensor client = open(sensor);
  subscribe(client, sensor);
  std::optional<stof::Frame> frame;
  for (std::uint32_t number = 1; number < 4; ++number) {
    const std::int64_t now =
        std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
    std::vector<stof::test::Datagram> datagrams = stof::test::datagrams(frame_spec(number));
    for (stof::test::Datagram& datagram : datagrams) {
      datagram[19] = std::byte{0};  // clock: the sensor's own
      for (std::size_t i = 0; i < 8; ++i) {
        datagram[24 + i] = static_cast<std::byte>(now >> (8 * i));
      }
      stof::test::reseal(datagram);
    }
    send(sensor, datagrams);
    frame = client.next(10s);
    ASSERT_TRUE(frame);
    // Sent after it was stamped, and it cannot lie in the future; the system's stamps of arrivals
    // are mapped from its wall clock, which somebody may be setting.
    ASSERT_TRUE(frame->exposure_here());
    const std::chrono::nanoseconds here = frame->exposure_here()->time_since_epoch();
    EXPECT_GE(here + 10ms, std::chrono::nanoseconds(now));
    EXPECT_LE(here - 10ms, std::chrono::steady_clock::now().time_since_epoch());
  }
  const auto clock = client.clock();
  ASSERT_TRUE(clock);
  EXPECT_GE(clock->offset_ns, -10'000'000);
  EXPECT_GE(clock->spread_ns, 0);
  EXPECT_GE(clock->age_ns, 0);
}

TEST(LibPoints, HaveTheirPixelAndItsGreyValue) {
  stof::test::Sensor sensor;
  stof::Sensor client = open(sensor);
  subscribe(client, sensor);
  std::vector<stof::PixelPoint> points;
  send(sensor, all_streams(5));
  auto frame = client.next(10s);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->pixel_points(points), STOF_NOT_YET);
  send(sensor, {calibration()});
  send(sensor, all_streams(6));
  frame = client.next(10s);
  ASSERT_TRUE(frame);
  ASSERT_EQ(frame->pixel_points(points), STOF_OK);
  std::vector<stof::Point> plain;
  ASSERT_EQ(frame->points(plain), STOF_OK);
  ASSERT_EQ(points.size(), plain.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const stof::PixelPoint& point = points[i];
    ASSERT_EQ(point.u, i % 64);
    ASSERT_EQ(point.v, i / 64);
    ASSERT_EQ(point.x, plain[i].x);
    ASSERT_EQ(point.z_width, plain[i].z_width);
    ASSERT_EQ(point.source, plain[i].source);
    ASSERT_EQ(point.cause, frame->cause().at(point.u, point.v));
    ASSERT_EQ(point.has_grey, 1U);
    ASSERT_EQ(point.grey, frame->left().at(point.u, point.v));
  }
  // Without the left picture, and with a row that did not arrive.
  send(sensor, stof::test::datagrams(frame_spec(7)));
  frame = client.next(10s);
  ASSERT_TRUE(frame);
  std::size_t count = 0;
  EXPECT_EQ(stof_pixel_points(&frame->c(), nullptr, 1, &count), STOF_BAD_ARGUMENT);
  EXPECT_EQ(stof_pixel_points(nullptr, nullptr, 0, &count), STOF_BAD_ARGUMENT);
}

TEST(LibRaw, TakesASensorAndSaysWhatItIs) {
  stof::test::Sensor sensor;
  stof::Sensor plain = open(sensor);
  stof_status status = STOF_OK;
  EXPECT_FALSE(plain.next_raw(&status));
  EXPECT_EQ(status, STOF_UNSUPPORTED) << "not asked for";
  stof_options options = STOF_INIT(stof_options);
  options.raw_pictures = STOF_RAW_LEFT;
  std::string why;
  EXPECT_FALSE(stof::Sensor::open(options, &why));
  EXPECT_NE(why.find("raw_pictures"), std::string::npos) << why;
  const std::string at = stof::test::endpoint(sensor);
  options.sensor = at.c_str();
  options.raw_step = 300;
  EXPECT_FALSE(stof::Sensor::open(options, &why));
  options.raw_step = 2;
  auto client = stof::Sensor::open(options, &why);
  ASSERT_TRUE(client) << why;
  for (int i = 0; i < 6000 && sensor.list().count != 1; ++i) {
    static_cast<void>(client->next(5ms));
  }
  // This sensor has no keys' keeper: it gives raw pictures to nobody.
  for (int i = 0; i < 6000 && status != STOF_REFUSED; ++i) {
    static_cast<void>(client->next(5ms));
    static_cast<void>(client->next_raw(&status));
  }
  EXPECT_EQ(status, STOF_REFUSED);
  EXPECT_EQ(stof_next_raw(nullptr, nullptr), STOF_BAD_ARGUMENT);
}

}  // namespace
