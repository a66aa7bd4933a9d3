#include "host/viewer/broadcast.h"

#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace stof::viewer {
namespace {

// A page, and what it has been sent.
class Reader {
 public:
  explicit Reader(Broadcast& all) : conversation_(all.open_conversation()) {}

  bool say(std::string_view message) { return conversation_->take(message); }
  // "" where nothing is due; "frame" and its facts, or the text.
  std::string next() {
    std::vector<std::uint8_t> bytes{'x', 'x'};
    const std::optional<MessageKind> kind = conversation_->next(bytes);
    if (!kind) {
      EXPECT_EQ(bytes.size(), 2U);
      return "";
    }
    const std::string text(bytes.begin() + 2, bytes.end());
    return *kind == MessageKind::kText ? text : "frame " + text.substr(5, text.find(',', 5) - 5);
  }

 private:
  std::unique_ptr<Conversation> conversation_;
};

constexpr const char* kOneDepth = R"({"show":["depth"],"frames":1,"quiet":false})";
constexpr const char* kTwoDepths = R"({"show":["depth"],"frames":2,"quiet":false})";
constexpr const char* kQuiet = R"({"show":[],"frames":0,"quiet":true})";

FramePlanes frame(int number) {
  return {.facts = "\"frame\":" + std::to_string(number),
          .width = 1,
          .height = 1,
          .depth = {static_cast<dsp::QuarterMm>(number)}};
}

class BroadcastTest : public testing::Test {
 protected:
  Broadcast all_{"hello", std::chrono::hours(1)};
};

TEST_F(BroadcastTest, GreetsFirst) {
  EXPECT_FALSE(all_.visited());
  Reader page(all_);
  EXPECT_TRUE(all_.visited());
  all_.tell_event("event");
  EXPECT_EQ(page.next(), "hello");
  EXPECT_EQ(page.next(), "event");
  EXPECT_EQ(page.next(), "");
}

TEST_F(BroadcastTest, SendsAFrameForEachThatWasAskedForAndTheNewest) {
  Reader page(all_);
  page.next();
  all_.show(frame(1));
  EXPECT_EQ(page.next(), "");
  EXPECT_FALSE(all_.wanted());
  ASSERT_TRUE(page.say(kOneDepth));
  EXPECT_TRUE(all_.wanted());
  all_.show(frame(2));
  all_.show(frame(3));
  EXPECT_EQ(page.next(), "frame \"frame\":3");
  EXPECT_FALSE(all_.wanted());
  all_.show(frame(4));
  EXPECT_EQ(page.next(), "");
  ASSERT_TRUE(page.say(kTwoDepths));
  ASSERT_TRUE(page.say(kTwoDepths));  // more than two are never owed
  EXPECT_EQ(page.next(), "frame \"frame\":4");
  EXPECT_EQ(page.next(), "");  // the same one is not sent again
  all_.show(frame(5));
  EXPECT_EQ(page.next(), "frame \"frame\":5");
  all_.show(frame(6));
  EXPECT_EQ(page.next(), "");
}

TEST_F(BroadcastTest, APageThatLeavesNoLongerWaits) {
  {
    Reader page(all_);
    ASSERT_TRUE(page.say(kOneDepth));
    Reader other(all_);
    ASSERT_TRUE(other.say(kOneDepth));
    EXPECT_TRUE(all_.wanted());
  }
  EXPECT_FALSE(all_.wanted());
}

TEST_F(BroadcastTest, AHiddenPageGetsEventsAlone) {
  Reader page(all_);
  page.next();
  ASSERT_TRUE(page.say(kTwoDepths));
  ASSERT_TRUE(page.say(kQuiet));
  EXPECT_FALSE(all_.wanted());
  all_.show(frame(1));
  all_.tell_status("status");
  EXPECT_EQ(page.next(), "");
  all_.tell_event("event");
  EXPECT_EQ(page.next(), "event");
  ASSERT_TRUE(page.say(kOneDepth));
  EXPECT_EQ(page.next(), "status");
  EXPECT_EQ(page.next(), "frame \"frame\":1");
}

TEST_F(BroadcastTest, ALaterPageGetsTheNewestStatusAndTheLastEvents) {
  for (std::size_t i = 1; i <= Broadcast::kMostEvents + 5; ++i) {
    all_.tell_event("event " + std::to_string(i));
  }
  all_.tell_status("old");
  all_.tell_status("new");
  Reader page(all_);
  EXPECT_EQ(page.next(), "hello");
  for (std::size_t i = 6; i <= Broadcast::kMostEvents + 5; ++i) {
    ASSERT_EQ(page.next(), "event " + std::to_string(i));
  }
  EXPECT_EQ(page.next(), "new");
  EXPECT_EQ(page.next(), "");
}

TEST(BroadcastAgeTest, AnOldFrameIsNotServedAsANewOne) {
  Broadcast all("hello", std::chrono::milliseconds(1));
  Reader page(all);
  page.next();
  ASSERT_TRUE(page.say(kOneDepth));
  all.show(frame(1));
  std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(page.next(), "");
  EXPECT_TRUE(all.wanted());  // the next one will do
}

TEST_F(BroadcastTest, RefusesWhatMeansNothing) {
  Reader page(all_);
  for (const char* message :
       {"", "null", "[]", "{}", "{", R"({"show":["depth"],"frames":1})",
        R"({"show":["depth"],"frames":1,"quiet":false,"more":1})",
        R"({"show":["depth"],"frames":3,"quiet":false})",
        R"({"show":["depth"],"frames":-1,"quiet":false})",
        R"({"show":["depth"],"frames":1.0,"quiet":false})",
        R"({"show":["depth"],"frames":99999999999999999999,"quiet":false})",
        R"({"show":["Depth"],"frames":1,"quiet":false})",
        R"({"show":[0],"frames":1,"quiet":false})", R"({"show":{},"frames":1,"quiet":false})",
        R"({"show":[],"frames":1,"quiet":"no"})"}) {
    EXPECT_FALSE(page.say(message)) << message;
  }
  EXPECT_FALSE(page.say(std::string(1000, '[')));
  EXPECT_FALSE(all_.wanted());
}

}  // namespace
}  // namespace stof::viewer
