// Frames of libstof that stay beyond the next one.
#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <thread>
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

TEST(KeptFrame, AHundredAreHeldWhileTenThousandPass) {
  stof::test::Sensor sensor;
  stof::Sensor client = open(sensor);
  subscribe(client, sensor);
  std::vector<stof::KeptFrame> kept;
  std::vector<std::vector<std::uint16_t>> was;
  std::uint32_t passed = 0;
  for (std::uint32_t number = 1; number <= 10'100; ++number) {
    send(sensor, stof::test::datagrams(stof::test::frame_spec(number)));
    const auto frame = client.next(10s);
    ASSERT_TRUE(frame);
    if (number % 101 == 1) {  // they lie between those that pass
      was.push_back(depths(frame->c()));
      kept.emplace_back(*frame);
      ASSERT_TRUE(kept.back().ok());
    } else {
      ++passed;
    }
  }
  EXPECT_EQ(kept.size(), 100U);
  EXPECT_EQ(passed, 10'000U);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    ASSERT_EQ(kept[i]->number(), 101 * i + 1);
    ASSERT_EQ(depths(kept[i]->c()), was[i]) << i;
    ASSERT_NE(i == 0 ? std::vector<std::uint16_t>() : was[i - 1], was[i]);
  }
}

// One frame for three readers of one process, each on a thread of its own and as slow as it likes.
TEST(KeptFrame, ThreeReadersHoldOneCopy) {
  constexpr std::uint32_t kFrames = 200;
  struct Reader {
    std::mutex mutex;
    std::condition_variable came;
    std::vector<stof::KeptFrame> queue;
    std::vector<const void*> places;  // of the pixels that it saw
    std::vector<std::vector<std::uint16_t>> saw;
    std::size_t points = 0;
  };
  std::array<Reader, 3> readers;
  std::vector<std::thread> threads;
  threads.reserve(readers.size());
  for (Reader& reader : readers) {
    threads.emplace_back([&reader] {
      std::vector<stof::Point> points;
      while (reader.saw.size() < kFrames) {
        std::vector<stof::KeptFrame> got;
        {
          std::unique_lock lock(reader.mutex);
          reader.came.wait(lock, [&reader] { return !reader.queue.empty(); });
          got.swap(reader.queue);
        }
        for (const stof::KeptFrame& frame : got) {
          reader.places.push_back(frame->c().depth.data);
          reader.saw.push_back(depths(frame->c()));
          reader.points += frame->points(points) == STOF_OK ? points.size() : 0;
        }
      }
    });
  }
  stof::test::Sensor sensor;
  stof::Sensor client = open(sensor);
  subscribe(client, sensor);
  send(sensor, {calibration()});
  std::vector<const void*> places;
  std::vector<std::vector<std::uint16_t>> was;
  for (std::uint32_t number = 1; number <= kFrames; ++number) {
    send(sensor, all_streams(number));
    const auto frame = client.next(10s);
    // Without a frame the readers end as well.
    EXPECT_TRUE(frame);
    const stof::KeptFrame kept(frame.value_or(stof::Frame()));
    places.push_back(kept->c().depth.data);
    was.push_back(depths(kept->c()));
    for (Reader& reader : readers) {
      const std::scoped_lock lock(reader.mutex);
      reader.queue.push_back(kept);
      reader.came.notify_one();
    }
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  for (const Reader& reader : readers) {
    EXPECT_EQ(reader.places, places) << "copied";
    EXPECT_EQ(reader.saw, was);
    EXPECT_EQ(reader.points, std::size_t{kFrames} * 64 * 48);
  }
}

// Who keeps into a frame that a reader still holds gets another one, and the reader's stays.
TEST(KeptFrame, WhatOthersHoldIsNotWrittenTo) {
  stof::test::Sensor sensor;
  stof::Sensor client = open(sensor);
  subscribe(client, sensor);
  send(sensor, all_streams(5));
  auto frame = client.next(10s);
  ASSERT_TRUE(frame);
  stof_kept* kept = nullptr;
  ASSERT_EQ(stof_keep(frame->fill(), &kept), STOF_OK);
  const stof_frame first = frame->c();
  const std::vector<std::uint16_t> was = depths(first);
  stof_kept* const held = stof_hold(kept);
  EXPECT_EQ(held, kept);
  for (std::uint32_t number = 6; number < 16; ++number) {
    send(sensor, all_streams(number));
    frame = client.next(10s);
    ASSERT_TRUE(frame);
    ASSERT_EQ(stof_keep(frame->fill(), &kept), STOF_OK);
    EXPECT_NE(kept, held);
    EXPECT_EQ(depths(first), was);
  }
  stof_release(kept);
  std::size_t count = 0;
  EXPECT_EQ(stof_points(&first, nullptr, 0, &count), STOF_NOT_YET) << "no calibration";
  stof_release(held);
  EXPECT_EQ(stof_hold(nullptr), nullptr);
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
