#include <cstring>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/viewer/foxglove/foxglove_channels.h"
#include "host/viewer/foxglove/foxglove_message.h"

namespace stof::viewer {
namespace {

using Json = nlohmann::json;

recording::Buffer message(std::uint8_t value) { return {4, static_cast<std::byte>(value)}; }

// A client, and what it has been sent.
class FoxgloveClient {
 public:
  explicit FoxgloveClient(FoxgloveChannels& all) : conversation_(all.open_conversation()) {}

  bool say(const Json& said) { return conversation_->take(said.dump()); }
  bool say_bytes(std::string_view said) { return conversation_->take(said); }
  bool subscribe(std::uint32_t id, bridge::Topic topic) {
    return say(
        {{"op", "subscribe"}, {"subscriptions", {{{"id", id}, {"channelId", channel_of(topic)}}}}});
  }
  bool unsubscribe(std::uint32_t id) {
    return say({{"op", "unsubscribe"}, {"subscriptionIds", {id}}});
  }
  // Null where nothing is due; a binary message as {id, value}.
  Json next() {
    std::vector<std::uint8_t> bytes{'x', 'x'};
    const std::optional<MessageKind> kind = conversation_->next(bytes);
    if (!kind) {
      EXPECT_EQ(bytes.size(), 2U);
      return nullptr;
    }
    if (*kind == MessageKind::kText) {
      return Json::parse(bytes.begin() + 2, bytes.end());
    }
    // Opcode, subscription, time, message.
    EXPECT_EQ(bytes.size(), 2 + 1 + 4 + 8 + 4U);
    EXPECT_EQ(bytes.at(2), 1);
    std::uint32_t id = 0;
    std::uint64_t time_ns = 0;
    std::memcpy(&id, bytes.data() + 3, sizeof id);
    std::memcpy(&time_ns, bytes.data() + 7, sizeof time_ns);
    EXPECT_GT(time_ns, std::uint64_t{1'600'000'000} * 1'000'000'000);
    return {{"id", id}, {"value", bytes.back()}};
  }
  void greet() {
    EXPECT_EQ(next()["op"], "serverInfo");
    EXPECT_EQ(next()["op"], "advertise");
  }

 private:
  std::unique_ptr<Conversation> conversation_;
};

Json data(std::uint32_t id, int value) { return {{"id", id}, {"value", value}}; }

class FoxgloveTest : public testing::Test {
 protected:
  int woken_ = 0;
  FoxgloveChannels all_{"stof x", std::chrono::hours(1), [this] { ++woken_; }};
};

TEST_F(FoxgloveTest, GreetsWithItselfAndAllChannelsWithTheirDefinitions) {
  EXPECT_FALSE(all_.visited());
  FoxgloveClient client(all_);
  EXPECT_TRUE(all_.visited());
  const Json info = client.next();
  EXPECT_EQ(info["op"], "serverInfo");
  EXPECT_EQ(info["name"], "stof x");
  EXPECT_TRUE(info["capabilities"].is_array() && info["capabilities"].empty());
  const Json channels = client.next()["channels"];
  ASSERT_EQ(channels.size(), 5U);
  std::map<std::string, std::string> schemas;
  for (const Json& one : channels) {
    EXPECT_EQ(one["encoding"], "cdr");
    EXPECT_EQ(one["schemaEncoding"], "ros2msg");
    EXPECT_FALSE(one["schema"].get<std::string>().empty());
    schemas[one["topic"]] = one["schemaName"];
  }
  EXPECT_EQ(schemas, (std::map<std::string, std::string>{
                         {"/stof/depth/image_raw", "sensor_msgs/msg/Image"},
                         {"/stof/depth/camera_info", "sensor_msgs/msg/CameraInfo"},
                         {"/stof/depth/points", "sensor_msgs/msg/PointCloud2"},
                         {"/diagnostics", "diagnostic_msgs/msg/DiagnosticArray"},
                         {"/tf_static", "tf2_msgs/msg/TFMessage"}}));
  EXPECT_EQ(client.next(), nullptr);
}

TEST_F(FoxgloveTest, SendsTheNewestOfWhatIsSubscribedOnce) {
  FoxgloveClient client(all_);
  client.greet();
  EXPECT_FALSE(all_.wanted(bridge::Topic::kDepth));
  all_.publish(bridge::Topic::kDepth, message(1));
  EXPECT_EQ(client.next(), nullptr);
  EXPECT_EQ(woken_, 0);
  ASSERT_TRUE(client.subscribe(70, bridge::Topic::kDepth));
  EXPECT_TRUE(all_.wanted(bridge::Topic::kDepth));
  EXPECT_FALSE(all_.wanted(bridge::Topic::kPoints));
  all_.publish(bridge::Topic::kDepth, message(2));
  all_.publish(bridge::Topic::kDepth, message(3));
  EXPECT_EQ(woken_, 2);
  EXPECT_EQ(client.next(), data(70, 3));
  EXPECT_EQ(client.next(), nullptr);
  ASSERT_TRUE(client.unsubscribe(70));
  EXPECT_FALSE(all_.wanted(bridge::Topic::kDepth));
  all_.publish(bridge::Topic::kDepth, message(4));
  EXPECT_EQ(client.next(), nullptr);
}

TEST_F(FoxgloveTest, NoTopicKeepsAnotherWaiting) {
  FoxgloveClient client(all_);
  client.greet();
  ASSERT_TRUE(client.subscribe(1, bridge::Topic::kDepth));
  ASSERT_TRUE(client.subscribe(2, bridge::Topic::kPoints));
  all_.publish(bridge::Topic::kPoints, message(9));
  all_.publish(bridge::Topic::kDepth, message(1));
  EXPECT_EQ(client.next(), data(1, 1));
  all_.publish(bridge::Topic::kDepth, message(2));  // always a new one
  EXPECT_EQ(client.next(), data(2, 9));
  EXPECT_EQ(client.next(), data(1, 2));
}

TEST_F(FoxgloveTest, WhoSubscribesLaterOrAgainGetsWhatIsTold) {
  all_.publish(bridge::Topic::kTransforms, message(5));
  FoxgloveClient client(all_);
  client.greet();
  for (std::uint32_t id = 0; id < 3; ++id) {
    ASSERT_TRUE(client.subscribe(id, bridge::Topic::kTransforms));
    EXPECT_EQ(client.next(), data(id, 5));
    EXPECT_EQ(client.next(), nullptr);
    ASSERT_TRUE(client.unsubscribe(id));
  }
}

TEST_F(FoxgloveTest, AClientThatLeavesNoLongerWants) {
  {
    FoxgloveClient client(all_);
    ASSERT_TRUE(client.subscribe(1, bridge::Topic::kDepth));
    EXPECT_TRUE(all_.wanted(bridge::Topic::kDepth));
  }
  EXPECT_FALSE(all_.wanted(bridge::Topic::kDepth));
}

TEST_F(FoxgloveTest, WhatIsNotOfferedIsRefusedByAStatus) {
  FoxgloveClient client(all_);
  client.greet();
  const auto refused = [&] {
    const Json status = client.next();
    return status["op"] == "status" && status["level"] == 2;
  };
  ASSERT_TRUE(
      client.say({{"op", "subscribe"}, {"subscriptions", {{{"id", 1}, {"channelId", 6}}}}}));
  EXPECT_TRUE(refused());
  ASSERT_TRUE(
      client.say({{"op", "subscribe"}, {"subscriptions", {{{"id", 1}, {"channelId", 0}}}}}));
  EXPECT_TRUE(refused());
  ASSERT_TRUE(client.subscribe(1, bridge::Topic::kDepth));
  ASSERT_TRUE(client.subscribe(1, bridge::Topic::kPoints));  // the id is taken
  EXPECT_TRUE(refused());
  ASSERT_TRUE(client.subscribe(2, bridge::Topic::kDepth));  // one for each channel
  EXPECT_TRUE(refused());
  ASSERT_TRUE(client.unsubscribe(2));
  EXPECT_TRUE(refused());
  ASSERT_TRUE(client.say({{"op", "getParameters"}}));
  EXPECT_TRUE(refused());
  EXPECT_EQ(client.next(), nullptr);
  EXPECT_FALSE(all_.wanted(bridge::Topic::kPoints));
}

TEST_F(FoxgloveTest, WhatMeansNothingEndsTheConnection) {
  FoxgloveClient client(all_);
  for (const char* said :
       {"", "null", "[]", "{}", "{", "\xff", R"({"op":1})", R"({"op":"subscribe"})",
        R"({"op":"subscribe","subscriptions":{}})", R"({"op":"subscribe","subscriptions":[1]})",
        R"({"op":"subscribe","subscriptions":[{"id":1}]})",
        R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":1}]})",
        R"({"op":"subscribe","subscriptions":[{"id":4294967296,"channelId":1}]})",
        R"({"op":"subscribe","subscriptions":[{"id":1.5,"channelId":1}]})",
        R"({"op":"unsubscribe","subscriptionIds":["1"]})",
        R"({"op":"unsubscribe","subscriptionIds":1})"}) {
    EXPECT_FALSE(client.say_bytes(said)) << said;
  }
  Json many{{"op", "unsubscribe"}, {"subscriptionIds", Json::array()}};
  for (int i = 0; i < 65; ++i) {
    many["subscriptionIds"].push_back(i);
  }
  EXPECT_FALSE(client.say(many));
}

TEST_F(FoxgloveTest, WhoAsksWithoutEndIsCutOff) {
  FoxgloveClient client(all_);
  int taken = 0;
  while (taken < 1'000'000 && client.unsubscribe(1)) {
    ++taken;
  }
  EXPECT_GE(taken, 10);
  EXPECT_LT(taken, 1'000'000);
}

TEST(FoxgloveAgeTest, AnOldFrameIsNotServedAsANewOneAndWhatIsTrueStays) {
  FoxgloveChannels all("x", std::chrono::milliseconds(1), [] {});
  FoxgloveClient client(all);
  client.greet();
  ASSERT_TRUE(client.subscribe(1, bridge::Topic::kDepth));
  ASSERT_TRUE(client.subscribe(2, bridge::Topic::kTransforms));
  all.publish(bridge::Topic::kDepth, message(1));
  all.publish(bridge::Topic::kTransforms, message(2));
  std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(client.next(), data(2, 2));
  EXPECT_EQ(client.next(), nullptr);
  EXPECT_TRUE(all.wanted(bridge::Topic::kDepth));
}

}  // namespace
}  // namespace stof::viewer
