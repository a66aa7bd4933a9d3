#include "host/viewer/frame_message.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "dataset/dataset.h"

namespace stof::viewer {
namespace {

struct Message {
  nlohmann::json head{};
  std::vector<std::uint8_t> planes{};
};

Message read(const std::vector<std::uint8_t>& bytes) {
  std::size_t size = 0;
  for (std::size_t i = 4; i > 0; --i) {
    size = size << 8U | bytes.at(i - 1);
  }
  EXPECT_EQ((4 + size) % 8, 0U);  // so that planes of words lie at even places
  const auto begin = bytes.begin() + 4;
  const auto end = begin + static_cast<std::ptrdiff_t>(size);
  return {.head = nlohmann::json::parse(begin, end), .planes = {end, bytes.end()}};
}

Message message(const FramePlanes& frame, Planes wanted) {
  std::vector<std::uint8_t> bytes;
  append_frame_message(frame, wanted, bytes);
  return read(bytes);
}

// 2 x 1 pixels.
struct Sent {
  dataset::Image<dsp::QuarterMm> depth{2, 1};
  dataset::Image<dsp::QuarterMm> width{2, 1};
  dataset::Image<dsp::Source> source{2, 1};
  dataset::Image<std::uint8_t> left{2, 1};
  client::Frame frame{};

  Sent() {
    depth.pixels = {0x0102, 0};
    width.pixels = {0x0304, 0};
    source.pixels = {dsp::Source::kBoth, dsp::Source::kConflict};
    left.pixels = {7, 8};
    frame.stamp.number = 42;
    frame.depth = std::as_const(depth).view();
    frame.interval_width = std::as_const(width).view();
    frame.source = std::as_const(source).view();
    frame.left = std::as_const(left).view();
  }
};

using Bytes = std::vector<std::uint8_t>;

TEST(FrameMessageTest, CarriesThePlanesThatAreWanted) {
  const Sent sent;
  const FramePlanes frame = copy_of(sent.frame, 12.5);
  const Message all = message(frame, kAllPlanes);
  EXPECT_EQ(all.head["frame"], 42);
  EXPECT_EQ(all.head["latency_ms"], 12.5);
  EXPECT_EQ(all.head["size"], nlohmann::json({2, 1}));
  EXPECT_EQ(all.head["planes"], nlohmann::json({"depth", "width", "source", "left"}));
  EXPECT_EQ(all.planes, (Bytes{2, 1, 0, 0, 4, 3, 0, 0, 3, 5, 7, 8}));
  const Message two = message(frame, kDepth | kSource);
  EXPECT_EQ(two.head["planes"], nlohmann::json({"depth", "source"}));
  EXPECT_EQ(two.planes, (Bytes{2, 1, 0, 0, 3, 5}));
  EXPECT_TRUE(message(frame, 0).planes.empty());
}

TEST(FrameMessageTest, WhatWasNotSentIsAbsent) {
  Sent sent;
  sent.frame.left = {};
  sent.frame.source = {};
  const Message some = message(copy_of(sent.frame, std::nullopt), kAllPlanes);
  EXPECT_EQ(some.head["planes"], nlohmann::json({"depth", "width"}));
  EXPECT_EQ(some.head["left_size"], nlohmann::json({0, 0}));
  EXPECT_TRUE(some.head["latency_ms"].is_null());
  EXPECT_TRUE(some.head["calibration"].is_null());
  EXPECT_EQ(message(copy_of(client::Frame{}, std::nullopt), kAllPlanes).head["size"],
            nlohmann::json({0, 0}));
}

TEST(FrameMessageTest, HasTheCalibrationOfItsOwnSizeAlone) {
  Sent sent;
  sent.frame.calibration = wire::CalibrationPacket{
      .image_width = 2, .image_height = 1, .fx = 3 << 15, .max_range = 40'000};
  const nlohmann::json calibration =
      message(copy_of(sent.frame, std::nullopt), 0).head["calibration"];
  EXPECT_EQ(calibration["fx"], 1.5);
  EXPECT_EQ(calibration["max_range_m"], 10.0);
  sent.frame.calibration->image_width = 4;
  EXPECT_TRUE(message(copy_of(sent.frame, std::nullopt), 0).head["calibration"].is_null());
}

TEST(FrameMessageTest, KnowsItsPlanesByName) {
  EXPECT_EQ(plane_named("width"), kWidth);
  EXPECT_EQ(plane_named("Width"), std::nullopt);
  EXPECT_EQ(plane_named(""), std::nullopt);
}

}  // namespace
}  // namespace stof::viewer
