// libstof's C interface against the network end of a sensor.
#include <atomic>
#include <cstddef>
#include <cstdio>
#include <thread>

#include <gtest/gtest.h>
#include <stof/stof.h>
#include <stof/stof.hpp>

#include "firmware/wire/messages/event.h"
#include "firmware/wire/messages/health.h"
#include "host/client/control/user_keys.h"
#include "tests/firmware/keys/some_keys.h"
#include "tests/host/lib/lib_sensor.h"

namespace {

using namespace std::chrono_literals;
using stof::test::all_streams;
using stof::test::calibration;
using stof::test::Datagram;
using stof::test::endpoint;
using stof::test::frame_spec;
using stof::test::open;
using stof::test::send;
using stof::test::subscribe;

TEST(Lib, GivesEveryStreamOfAFrame) {
  stof::test::Sensor sensor;
  stof::Sensor client = open(sensor);
  subscribe(client, sensor);
  send(sensor, {calibration()});
  send(sensor, all_streams(5));
  const auto frame = client.next(10s);
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->complete());
  EXPECT_EQ(frame->number(), 5U);
  EXPECT_EQ(frame->exposure_middle(), 5ms);
  const stof_frame& c = frame->c();
  for (const stof_plane* const plane :
       {&c.depth, &c.interval_width, &c.source, &c.cause, &c.disparity, &c.left, &c.right}) {
    EXPECT_EQ(plane->width, 64U);
    EXPECT_EQ(plane->height, 48U);
    EXPECT_EQ(plane->stride, 64 * plane->pixel_bytes);
    EXPECT_EQ(plane->bytes, 64 * 48 * plane->pixel_bytes);
    EXPECT_EQ(plane->missing, 0U);
  }
  for (const stof_plane& plane : c.pmd) {
    EXPECT_EQ(plane.width, 16U);
    EXPECT_EQ(plane.height, 12U);
  }
  EXPECT_EQ(c.cloud.width, 8U);
  EXPECT_EQ(c.cloud.pixel_bytes, 8U);
  stof::test::PatternFrame told(5, {});
  const auto images = told.images();
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      ASSERT_EQ(frame->depth().at(x, y), images.map.depth.at(x, y));
      ASSERT_EQ(frame->left().at(x, y), images.left.at(x, y));
      ASSERT_TRUE(frame->depth().arrived(x, y));
    }
  }
  ASSERT_TRUE(frame->calibration());
  EXPECT_EQ(frame->calibration()->fx, 1.0);
  EXPECT_EQ(frame->calibration()->k[8], 1.0);
  EXPECT_EQ(frame->calibration()->depth_unit_m, 250e-6);
  ASSERT_TRUE(frame->info());
  EXPECT_EQ(frame->info()->sensors, STOF_SENSOR_STEREO) << "of a sensor that does not say";
  EXPECT_EQ(frame->settings_fingerprint(), 0U) << "likewise";
}

TEST(Lib, SaysHowOldItsNewestIs) {
  stof::test::Sensor sensor;
  stof::Sensor client = open(sensor);
  EXPECT_EQ(client.link().frame_age_ns, -1);
  subscribe(client, sensor);
  send(sensor, {calibration()});
  send(sensor, all_streams(5));
  ASSERT_TRUE(client.next(10s));
  const stof::Link link = client.link();
  EXPECT_GE(link.frame_age_ns, 0);
  EXPECT_GE(link.calibration_age_ns, 0);
  EXPECT_EQ(link.health_age_ns, -1);
  std::this_thread::sleep_for(300ms);
  EXPECT_EQ(client.link().conditions, STOF_LINK_SILENT);
  EXPECT_GT(client.link().frame_age_ns, link.frame_age_ns);
}

TEST(Lib, SaysOnHowManyFramesADepthStands) {
  stof::test::Sensor sensor;
  stof::Sensor client = open(sensor);
  subscribe(client, sensor);
  const auto send_standing_on = [&](std::uint32_t number, std::uint32_t frames) {
    stof::test::FrameSpec spec = frame_spec(number);
    spec.steady_frames = frames;
    send(sensor, stof::test::pattern_datagrams(
                     spec, {}, stof::test::every_stream(stof::wire::Coding::kRvl, false, 8)));
  };
  send_standing_on(5, 1234);
  auto frame = client.next(10s);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->steady_frames(), 1234U);
  EXPECT_EQ(frame->c().steady_frames, 1234U);
  send(sensor, all_streams(6));
  frame = client.next(10s);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->steady_frames(), 0U) << "of a sensor that does not say";
}

TEST(Lib, SaysWithWhichCalibrationAFrameWasMade) {
  stof::test::Sensor sensor;
  stof::Sensor client = open(sensor);
  subscribe(client, sensor);
  stof::test::FrameSpec spec = frame_spec(5);
  spec.calibration = 0x1234'5678;
  send(sensor, stof::test::datagrams(spec));
  auto frame = client.next(10s);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->calibration_fingerprint(), 0x1234'5678U);
  EXPECT_FALSE(frame->calibration());
  send(sensor, {stof::test::calibration_datagram(spec, 1)});
  spec.number = spec.freshness = 6;
  send(sensor, stof::test::datagrams(spec));
  frame = client.next(10s);
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->calibration());
}

// A program that was built before the last fields of a frame were there.
TEST(Lib, MakesPointsForAnOlderProgram) {
  stof::test::Sensor sensor;
  stof::Sensor client = open(sensor);
  subscribe(client, sensor);
  send(sensor, {calibration()});
  send(sensor, all_streams(5));
  const auto frame = client.next(10s);
  ASSERT_TRUE(frame);
  stof_frame older = frame->c();
  older.struct_size = offsetof(stof_frame, steady_frames);
  std::vector<stof_point> points(64 * 48);
  std::size_t count = 0;
  EXPECT_EQ(stof_points(&older, points.data(), points.size(), &count), STOF_OK);
  EXPECT_EQ(count, points.size());
  older.struct_size = offsetof(stof_frame, self);
  EXPECT_EQ(stof_points(&older, points.data(), points.size(), &count), STOF_BAD_ARGUMENT);
}

TEST(Lib, MakesPointsOfDepth) {
  stof::test::Sensor sensor;
  stof::Sensor client = open(sensor);
  subscribe(client, sensor);
  send(sensor, all_streams(5));
  auto frame = client.next(10s);
  ASSERT_TRUE(frame);
  std::vector<stof::Point> points;
  EXPECT_EQ(frame->points(points), STOF_NOT_YET);  // without calibration
  send(sensor, {calibration()});
  send(sensor, all_streams(6));
  frame = client.next(10s);
  ASSERT_TRUE(frame);
  ASSERT_EQ(frame->points(points), STOF_OK);
  ASSERT_EQ(points.size(), 64U * 48);  // each has a depth
  const float z = static_cast<float>(frame->depth().at(3, 2)) / 4000;
  EXPECT_FLOAT_EQ(points[2 * 64 + 3].z, z);
  EXPECT_FLOAT_EQ(points[2 * 64 + 3].x, 3 * z);
  EXPECT_FLOAT_EQ(points[2 * 64 + 3].y, 2 * z);
  std::size_t count = 0;
  stof_point one;
  EXPECT_EQ(stof_points(&frame->c(), &one, 1, &count), STOF_TOO_SMALL);
  EXPECT_EQ(count, points.size());
  EXPECT_EQ(one.z, points[0].z);
}

TEST(Lib, MarksWhatDidNotArrive) {
  stof::test::Sensor sensor;
  stof::Sensor client = open(sensor);
  subscribe(client, sensor);
  std::vector<Datagram> datagrams = stof::test::datagrams(frame_spec(1));
  datagrams.erase(datagrams.begin() + 1);  // the first row of depth
  send(sensor, datagrams);
  send(sensor, stof::test::datagrams(frame_spec(2)));
  const auto frame = client.next(10s);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->number(), 1U);
  EXPECT_FALSE(frame->complete());
  EXPECT_EQ(frame->depth().missing(), 300U);
  EXPECT_FALSE(frame->depth().arrived(0, 0));
  EXPECT_TRUE(frame->depth().arrived(0, 1));
  EXPECT_TRUE(frame->interval_width().arrived(0, 0));
}

TEST(Lib, CallsBackOnAThreadOfItsOwn) {
  stof::test::Sensor sensor;
  stof::Sensor client = open(sensor);
  std::atomic<int> frames{0};
  std::atomic<stof_status> stop_inside{STOF_OK};
  ASSERT_EQ(client.start({.frame =
                              [&](const stof::Frame& frame) {
                                std::vector<stof::Point> points;
                                EXPECT_EQ(frame.points(points), STOF_OK);
                                stop_inside = client.stop();
                                ++frames;
                              },
                          .health = {},
                          .event = {},
                          .failed = {}}),
            STOF_OK);
  EXPECT_EQ(client.start({}), STOF_BUSY);
  stof_status status = STOF_OK;
  EXPECT_FALSE(client.next(0ms, &status));
  EXPECT_EQ(status, STOF_BUSY);
  ASSERT_TRUE(sensor.reaches(1));
  send(sensor, {calibration()});
  for (std::uint32_t number = 1; number <= 5; ++number) {
    send(sensor, all_streams(number));
    for (int i = 0; i < 1000 && frames < static_cast<int>(number); ++i) {
      std::this_thread::sleep_for(5ms);
    }
  }
  EXPECT_EQ(frames, 5);
  EXPECT_EQ(stop_inside, STOF_BUSY);  // a thread cannot wait for itself
  EXPECT_EQ(client.statistics().frames_complete, 5U);
  EXPECT_EQ(client.stop(), STOF_OK);
  EXPECT_EQ(client.stop(), STOF_OK);
  EXPECT_EQ(client.start({}), STOF_OK);  // and again; ends with the sensor
}

TEST(Lib, TellsHealthAndEvents) {
  stof::test::Sensor sensor;
  stof::Sensor client = open(sensor);
  subscribe(client, sensor);
  EXPECT_FALSE(client.health());
  std::array<std::byte, stof::wire::kHealthReportBytes> health{};
  stof::wire::encode_health_report(
      {.uptime_ms = 5000, .active = 4, .rate_millihertz = 29'500, .latency_us = 40'000}, health);
  std::array<std::byte, stof::wire::kEventReportBytes> event{};
  stof::wire::encode_event_report({.sequence = 3,
                                   .condition = 2,
                                   .severity = stof::wire::Severity::kCritical,
                                   .reaction = stof::wire::Reaction::kStop,
                                   .active = 1},
                                  event);
  send(sensor, {stof::test::report_datagram(frame_spec(1), stof::wire::PacketType::kHealth, health),
                stof::test::report_datagram(frame_spec(1), stof::wire::PacketType::kEvent, event)});
  for (int i = 0; i < 1000 && !client.health(); ++i) {
    static_cast<void>(client.next(5ms));
  }
  ASSERT_TRUE(client.health());
  EXPECT_EQ(client.health()->uptime_ms, 5000U);
  EXPECT_DOUBLE_EQ(client.health()->rate_hz, 29.5);
  EXPECT_DOUBLE_EQ(client.health()->latency_s, 0.04);
  std::optional<stof::Event> told;
  for (int i = 0; i < 1000 && !told; ++i) {
    static_cast<void>(client.next(5ms));
    told = client.next_event();
  }
  ASSERT_TRUE(told);
  EXPECT_STREQ(stof_condition_name(told->condition), "stereo_lost");
  EXPECT_STREQ(stof_reaction_name(told->reaction), "stop");
  EXPECT_FALSE(client.next_event());
}

// A program that was built with a shorter or a longer structure.
TEST(Lib, WritesNoMoreThanTheCallerKnows) {
  stof::test::Sensor sensor;
  stof::Sensor client = open(sensor);
  subscribe(client, sensor);
  send(sensor, all_streams(9));
  struct Older {
    std::uint32_t words[4];
    std::uint32_t beyond;
  } older{{16, 0, 0, 0}, 0xABABABAB};
  ASSERT_EQ(stof_next(client.c(), 10'000, reinterpret_cast<stof_frame*>(&older)), STOF_OK);
  EXPECT_EQ(older.words[0], 16U);
  EXPECT_EQ(older.words[3], 9U);  // number
  EXPECT_EQ(older.beyond, 0xABABABABU);
  stof_statistics none{};
  EXPECT_EQ(stof_get_statistics(client.c(), &none), STOF_BAD_ARGUMENT);
}

TEST(Lib, RefusesWhatMakesNoSense) {
  char why[100] = "x";
  stof_sensor* sensor = nullptr;
  EXPECT_EQ(stof_open(nullptr, &sensor, why, sizeof why), STOF_BAD_ARGUMENT);
  EXPECT_NE(std::string(why), "");
  stof_options options = STOF_INIT(stof_options);
  options.sensor = "[::1";
  EXPECT_EQ(stof_open(&options, &sensor, why, sizeof why), STOF_BAD_ARGUMENT);
  EXPECT_EQ(sensor, nullptr);
  EXPECT_NE(std::string(why).find("[::1"), std::string::npos);
  EXPECT_EQ(stof_open(&options, &sensor, nullptr, 0), STOF_BAD_ARGUMENT);
  stof_frame frame = STOF_INIT(stof_frame);
  EXPECT_EQ(stof_next(nullptr, 0, &frame), STOF_BAD_ARGUMENT);
  std::size_t count = 0;
  EXPECT_EQ(stof_points(&frame, nullptr, 0, &count), STOF_BAD_ARGUMENT);
  EXPECT_EQ(stof_fd(nullptr), -1);
  stof_close(nullptr);
  EXPECT_EQ(stof_discover(10, nullptr, 1, nullptr, 0, 1, &count, nullptr, 0), STOF_BAD_ARGUMENT);
  EXPECT_STREQ(stof_status_text(-1), "unknown");
  EXPECT_STREQ(stof_status_text(STOF_INTERNAL), "internal error");
  EXPECT_STREQ(stof_condition_name(1000), "unknown");
}

TEST(Lib, TakesOnlyWhatIsSignedWhereThatWasAskedFor) {
  ASSERT_TRUE(stof::wire::start_crypto());
  stof::wire::Key key = stof::test::numbered_key(4, stof::wire::Role::kView);
  key.device = 0x51;
  stof::keys::Keyring ring(nullptr, nullptr);
  ASSERT_EQ(ring.add(key), stof::Status::kOk);
  stof::keys::Authenticator authenticator(ring);
  stof::test::Sensor sensor(nullptr, 0, 1, &authenticator);
  const std::string file = testing::TempDir() + "stof_lib_keys";
  stof::wire::KeyTable keys;
  ASSERT_EQ(keys.add(key), stof::Status::kOk);
  ASSERT_TRUE(stof::client::write_user_keys(file, keys));

  const std::string at = endpoint(sensor);
  stof_options options = STOF_INIT(stof_options);
  options.sensor = at.c_str();
  options.signed_streams = 1;
  options.keys = file.c_str();
  std::string why;
  auto client = stof::Sensor::open(options, &why);
  ASSERT_TRUE(client) << why;
  subscribe(*client, sensor);
  const stof::wire::StreamKey stream = sensor.list().keys[0];
  ASSERT_NE(stream.number, 0U);
  stof::wire::StreamTagger tagger(stream);
  std::uint64_t counter = 0;
  for (std::uint32_t number = 1; number <= 3; ++number) {
    // Somebody sends a frame in its name, then it sends its own.
    send(sensor, stof::test::datagrams(frame_spec(number)));
    stof::test::FrameSpec own = frame_spec(number);
    own.origin = sensor.origin;
    for (const Datagram& datagram : stof::test::datagrams(own)) {
      stof::wire::DatagramBuffer space{};
      const auto made = stof::wire::sign_datagram(datagram, tagger, ++counter, space);
      ASSERT_EQ(sensor.send(made), stof::Status::kOk);
    }
    const auto frame = client->next(10s);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->number(), number);
  }
  const stof_statistics statistics = client->statistics();
  EXPECT_EQ(statistics.packets_not_signed, counter);
  EXPECT_EQ(statistics.packets_forged, 0U);
  EXPECT_NE(client->link().conditions & STOF_LINK_FORGED, 0U);
  EXPECT_EQ(std::remove(file.c_str()), 0);
}

// Both say that they are number 0x51; only one has the key that is named.
TEST(Lib, BelievesOnlyTheSensorOfTheKeyThatIsNamed) {
  ASSERT_TRUE(stof::wire::start_crypto());
  const std::string file = testing::TempDir() + "stof_lib_key_ids";
  stof::wire::KeyTable keys;
  for (const std::uint32_t id : {4U, 5U}) {
    stof::wire::Key key = stof::test::numbered_key(id, stof::wire::Role::kView);
    key.device = 0x51;
    ASSERT_EQ(keys.add(key), stof::Status::kOk);
  }
  ASSERT_TRUE(stof::client::write_user_keys(file, keys));
  stof::keys::Keyring ring(nullptr, nullptr);
  ASSERT_EQ(ring.add(*keys.find(4)), stof::Status::kOk);
  stof::keys::Authenticator authenticator(ring);
  stof::test::Sensor sensor(nullptr, 0, 1, &authenticator);
  const std::string at = endpoint(sensor);
  stof_options options = STOF_INIT(stof_options);
  options.sensor = at.c_str();
  options.signed_streams = 1;
  options.device_id = 0x51;
  options.keys = file.c_str();
  for (const std::uint32_t id : {4U, 5U}) {
    options.key_id = id;
    std::string why;
    auto client = stof::Sensor::open(options, &why);
    ASSERT_TRUE(client) << why;
    const auto end = std::chrono::steady_clock::now() + (id == 4 ? 10s : 1s);
    while (sensor.list().count == 0 && std::chrono::steady_clock::now() < end) {
      static_cast<void>(client->next(10ms));
    }
    EXPECT_EQ(sensor.list().count, id == 4 ? 1U : 0U);
    client.reset();  // says farewell
    const auto left = std::chrono::steady_clock::now() + 10s;
    while (sensor.list().count != 0 && std::chrono::steady_clock::now() < left) {
      std::this_thread::sleep_for(10ms);
    }
    ASSERT_EQ(sensor.list().count, 0U);
  }
  options.key_id = 6;
  std::string why;
  EXPECT_FALSE(stof::Sensor::open(options, &why));
  EXPECT_NE(why.find("has no key 00000006"), std::string::npos) << why;
  EXPECT_EQ(std::remove(file.c_str()), 0);
}

TEST(Lib, SignedStreamsTakeASensorAndAKeyFileThatCanBeRead) {
  stof_options options = STOF_INIT(stof_options);
  options.signed_streams = 1;
  options.keys = "";
  std::string why;
  EXPECT_FALSE(stof::Sensor::open(options, &why));
  EXPECT_NE(why.find("name the sensor"), std::string::npos) << why;
  const std::string folder = testing::TempDir();
  options.sensor = "127.0.0.1";
  options.keys = folder.c_str();
  EXPECT_FALSE(stof::Sensor::open(options, &why));
  EXPECT_NE(why.find("no regular file"), std::string::npos) << why;
}

TEST(Lib, WithKeysOfSeveralSensorsItTakesTheNumberOfTheOneThatIsMeant) {
  const std::string file = testing::TempDir() + "stof_lib_several_keys";
  stof::wire::KeyTable keys;
  for (const std::uint32_t number : {1U, 2U}) {
    stof::wire::Key key = stof::test::numbered_key(number);
    key.device = number;
    ASSERT_EQ(keys.add(key), stof::Status::kOk);
  }
  ASSERT_TRUE(stof::client::write_user_keys(file, keys));
  stof_options options = STOF_INIT(stof_options);
  options.sensor = "127.0.0.1:9";
  options.signed_streams = 1;
  options.keys = file.c_str();
  std::string why;
  EXPECT_FALSE(stof::Sensor::open(options, &why));
  EXPECT_NE(why.find("several sensors (1, 2)"), std::string::npos) << why;
  EXPECT_NE(why.find("device_id"), std::string::npos) << why;
  options.device_id = 2;
  EXPECT_TRUE(stof::Sensor::open(options, &why)) << why;
  options.device_id = 0;
  options.signed_streams = 0;
  stof_sensor* sensor = nullptr;
  ASSERT_EQ(stof_open(&options, &sensor, nullptr, 0), STOF_OK);
  std::array<char, 256> text{};
  EXPECT_EQ(stof_settings(sensor, STOF_SET, STOF_ACTIVE, "{}", text.data(), text.size(), nullptr),
            STOF_UNSUPPORTED);
  stof_close(sensor);
  EXPECT_NE(std::string(text.data()).find("several sensors"), std::string::npos) << text.data();
  EXPECT_EQ(std::remove(file.c_str()), 0);
}

TEST(Lib, SaysThatNobodyAnswersForSettings) {
  std::uint16_t closed = 0;
  {
    closed = stof::test::Sensor().number();
  }
  auto client = stof::Sensor::open("127.0.0.1:" + std::to_string(closed));
  ASSERT_TRUE(client);
  const stof::Answer answer = client->get();
  EXPECT_EQ(answer.status, STOF_UNREACHABLE);
  EXPECT_NE(answer.text, "");
}

}  // namespace
