// Frames of libstof that stay beyond the next one.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include <gtest/gtest.h>
#include <stof/stof.h>
#include <stof/stof.hpp>

#include "tests/host/lib/lib_sensor.h"

namespace {

using namespace std::chrono_literals;
using stof::test::all_streams;
using stof::test::calibration;
using stof::test::open;
using stof::test::send;
using stof::test::subscribe;

std::vector<std::uint16_t> depths(const stof_frame& frame) {
  std::vector<std::uint16_t> out;
  for (int y = 0; y < static_cast<int>(frame.depth.height); ++y) {
    const auto* const row = stof::Image<std::uint16_t>(frame.depth).row(y);
    out.insert(out.end(), row, row + frame.depth.width);
  }
  return out;
}

TEST(KeptFrame, AKeptFrameStaysAsItWasBeyondTheNextOnesAndItsSensor) {
  stof::test::Sensor sensor;
  std::optional<stof::Sensor> client = open(sensor);
  subscribe(*client, sensor);
  send(sensor, {calibration()});
  std::vector<stof::KeptFrame> kept;
  std::vector<std::vector<std::uint16_t>> was;
  for (std::uint32_t number = 5; number < 15; ++number) {
    send(sensor, all_streams(number));
    const auto frame = client->next(10s);
    ASSERT_TRUE(frame);
    was.push_back(depths(frame->c()));
    kept.emplace_back(*frame);
    ASSERT_TRUE(kept.back().ok());
    EXPECT_EQ(kept.back()->c().depth.data, frame->c().depth.data) << "copied";
    EXPECT_FALSE(stof::KeptFrame(*frame).ok()) << "kept twice";
  }
  client.reset();
  std::vector<stof::Point> points;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    EXPECT_EQ(kept[i]->number(), 5 + i);
    EXPECT_EQ(depths(kept[i]->c()), was[i]);
    EXPECT_EQ(kept[i]->points(points), STOF_OK);
    EXPECT_EQ(points.size(), was[i].size());
  }
  EXPECT_NE(was.front(), was.back());
}

TEST(KeptFrame, TheMemoryOfAKeptFrameIsUsedAgain) {
  stof::test::Sensor sensor;
  stof::Sensor client = open(sensor);
  subscribe(client, sensor);
  stof_kept* kept = nullptr;
  std::vector<const void*> places;
  for (std::uint32_t number = 5; number < 105; ++number) {
    send(sensor, all_streams(number));
    auto frame = client.next(10s);
    ASSERT_TRUE(frame);
    ASSERT_EQ(stof_keep(frame->fill(), &kept), STOF_OK);
    if (std::ranges::find(places, frame->c().depth.data) == places.end()) {
      places.push_back(frame->c().depth.data);
    }
  }
  EXPECT_LE(places.size(), 5U) << "four frames of the sensor, and the one that is kept";
  stof_release(kept);
}

TEST(KeptFrame, KeepsNothingOfWhatIsOver) {
  stof::test::Sensor sensor;
  stof::Sensor client = open(sensor);
  subscribe(client, sensor);
  send(sensor, all_streams(5));
  auto older = client.next(10s);
  send(sensor, all_streams(6));
  ASSERT_TRUE(older);
  ASSERT_TRUE(client.next(10s));
  stof_kept* kept = nullptr;
  EXPECT_EQ(stof_keep(older->fill(), &kept), STOF_BAD_ARGUMENT);
  stof_frame none = STOF_INIT(stof_frame);
  EXPECT_EQ(stof_keep(&none, &kept), STOF_BAD_ARGUMENT);
  EXPECT_EQ(stof_keep(nullptr, &kept), STOF_BAD_ARGUMENT);
  EXPECT_EQ(stof_keep(older->fill(), nullptr), STOF_BAD_ARGUMENT);
  EXPECT_EQ(kept, nullptr);
  stof_release(nullptr);
}

TEST(Lib, TellsTheSizesOfItsStructures) {
  EXPECT_EQ(stof_struct_size("stof_frame"), sizeof(stof_frame));
  EXPECT_EQ(stof_struct_size("stof_found"), sizeof(stof_found));
  EXPECT_EQ(stof_struct_size("stof_sensor"), 0U);
  EXPECT_EQ(stof_struct_size(nullptr), 0U);
}

}  // namespace
