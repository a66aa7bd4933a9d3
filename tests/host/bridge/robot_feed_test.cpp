#include "host/bridge/robot_feed.h"

#include <map>

#include <gtest/gtest.h>

#include "host/bridge/block_cloud.h"

namespace stof::bridge {
namespace {

constexpr int kWidth = 5;
constexpr int kHeight = 3;

struct Message {
  Topic topic;
  recording::Buffer data;
};

class Sink final : public TopicSink {
 public:
  bool wanted(Topic topic) override { return !unwanted.contains(topic); }
  bool publish(Topic topic, recording::Buffer&& message) override {
    messages.push_back({.topic = topic, .data = std::move(message)});
    return takes;
  }
  int count(Topic topic) const {
    return static_cast<int>(
        std::ranges::count_if(messages, [&](const Message& m) { return m.topic == topic; }));
  }
  std::vector<Message> messages;
  std::map<Topic, bool> unwanted;
  bool takes = true;
};

class RobotFeedTest : public testing::Test {
 protected:
  RobotFeedTest()
      : depth_(kWidth * kHeight), width_(kWidth * kHeight, 8), received_(width_.size(), 7) {
    for (std::size_t k = 0; k < depth_.size(); ++k) {
      depth_[k] = static_cast<dsp::QuarterMm>(4000 + 4 * k);
    }
  }
  client::Frame frame() const {
    client::Frame frame{.origin = {.device_id = 9, .session_id = 2},
                        .stamp = {.number = 1, .exposure_middle_ns = 1000}};
    frame.depth = {depth_.data(), kWidth, kHeight};
    frame.interval_width = {width_.data(), kWidth, kHeight};
    frame.received = {received_.data(), kWidth, kHeight};
    frame.info.emplace();
    frame.info->latency_ns = 500;
    frame.info->calibration_fingerprint = 7;
    frame.calibration = wire::CalibrationPacket{.image_width = kWidth,
                                                .image_height = kHeight,
                                                .fx = 65536,
                                                .fy = 65536,
                                                .depth_unit_um = 250,
                                                .fingerprint = 7};
    return frame;
  }
  // Level and message of status k of the newest diagnostics.
  std::pair<int, std::string> status(int index) const {
    recording::CdrReader from(sink_.messages.back().data);
    from.number<std::uint64_t>();
    from.text();
    EXPECT_EQ(from.number<std::uint32_t>(), 2U);
    for (int k = 0;; ++k) {
      const int level = from.number<std::uint8_t>();
      from.text();
      const std::string message = from.text();
      from.text();
      if (k == index) {
        return {level, message};
      }
      for (auto values = from.number<std::uint32_t>(); values > 0; --values) {
        from.text();
        from.text();
      }
    }
  }

  std::vector<dsp::QuarterMm> depth_;
  std::vector<dsp::QuarterMm> width_;
  std::vector<std::uint8_t> received_;
  Sink sink_;
  RobotFeed feed_{sink_, {.name_space = "front", .cloud_step = 2}};
};

TEST_F(RobotFeedTest, FrameIsPublishedOnceInMillimetresOfSystemTime) {
  const std::int64_t stamp = feed_.show(
      frame(), {.first_packet_ns = 2000, .round_trip_ns = 100, .wall_offset_ns = 10'000});
  EXPECT_EQ(stamp, 11'500) << "arrival less latency, in system time";
  ASSERT_EQ(sink_.messages.size(), 3U);
  const auto image = recording::decode_image(sink_.messages[0].data);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->header.stamp_ns, stamp);
  EXPECT_EQ(image->header.frame_id, "front_left_optical_frame");
  EXPECT_EQ(image->encoding, "16UC1");
  ASSERT_EQ(image->data.size(), 2U * kWidth * kHeight);
  EXPECT_EQ(std::to_integer<int>(image->data[0]) + 256 * std::to_integer<int>(image->data[1]),
            1000);
}

TEST_F(RobotFeedTest, NothingIsMadeThatNobodyReads) {
  sink_.unwanted = {{Topic::kDepth, true}, {Topic::kCameraInfo, true}, {Topic::kPoints, true}};
  feed_.show(frame(), {.first_packet_ns = 2000});
  EXPECT_TRUE(sink_.messages.empty());
}

TEST_F(RobotFeedTest, FrameOfAnotherCalibrationHasNoLensAndNoCloud) {
  client::Frame other = frame();
  other.calibration->fingerprint = 8;
  feed_.show(other, {.first_packet_ns = 2000});
  other.calibration.reset();
  feed_.show(other, {.first_packet_ns = 3000});
  EXPECT_EQ(sink_.count(Topic::kDepth), 2);
  EXPECT_EQ(sink_.messages.size(), 2U);
}

TEST_F(RobotFeedTest, SilenceIsStaleAndBringsNoFrame) {
  feed_.show(frame(), {.first_packet_ns = 2000});
  sink_.messages.clear();
  feed_.tell({.trouble = "no frame for 3 s"}, 77);
  ASSERT_EQ(sink_.messages.size(), 1U);
  EXPECT_EQ(status(0), (std::pair<int, std::string>(3, "the sensor says nothing")));
  EXPECT_EQ(status(1), (std::pair<int, std::string>(3, "no frame for 3 s")));
  feed_.tell({.health = wire::HealthReport{}}, 78);
  EXPECT_EQ(status(0), (std::pair<int, std::string>(0, "good")));
  EXPECT_EQ(status(1), (std::pair<int, std::string>(0, "frames come")));
}

TEST_F(RobotFeedTest, ReplayIsNoSensor) {
  client::Frame replayed = frame();
  replayed.stamp.clock = wire::ClockState::kRecorded;
  feed_.show(replayed, {.first_packet_ns = 2000});
  feed_.tell({}, 77);
  EXPECT_EQ(status(1), (std::pair<int, std::string>(1, "REPLAY: nothing of it is new")));
}

TEST_F(RobotFeedTest, CloudShowsTheNearestOfEachBlock) {
  std::vector<client::Point> points;
  ASSERT_EQ(block_cloud(frame(), 2, points), Status::kOk);
  ASSERT_EQ(points.size(), 6U) << "blocks at the borders are smaller";
  EXPECT_FLOAT_EQ(points[0].z, 1.0F);
  EXPECT_FLOAT_EQ(points[0].z_width, 0.002F);
  EXPECT_FLOAT_EQ(points[1].x, 2 * 1.002F) << "the pixel's own direction";
  // A wide interval comes nearer than a smaller depth.
  width_[6] = 400;
  ASSERT_EQ(block_cloud(frame(), 2, points), Status::kOk);
  EXPECT_FLOAT_EQ(points[0].z, 1.006F);
  // Whose width did not arrive counts by its depth; what has no depth is no point.
  received_[6] = client::kHasDepth;
  ASSERT_EQ(block_cloud(frame(), 2, points), Status::kOk);
  EXPECT_FLOAT_EQ(points[0].z, 1.0F);
  depth_.assign(depth_.size(), dsp::kNoDepth);
  ASSERT_EQ(block_cloud(frame(), 2, points), Status::kOk);
  EXPECT_TRUE(points.empty());
}

TEST_F(RobotFeedTest, CloudTakesACalibrationOfItsSize) {
  std::vector<client::Point> points;
  client::Frame other = frame();
  other.calibration->image_width = kWidth + 1;
  EXPECT_EQ(block_cloud(other, 2, points), Status::kInvalidArgument);
  other.calibration.reset();
  EXPECT_EQ(block_cloud(other, 2, points), Status::kUnsupported);
}

}  // namespace
}  // namespace stof::bridge
