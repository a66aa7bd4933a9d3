#include "host/viewer/broadcast.h"

#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/viewer/rate_limit.h"

namespace stof::viewer {
namespace {

// A page, and what it has been sent.
class Reader {
 public:
  explicit Reader(Broadcast& all, const Visitor& visitor = {})
      : conversation_(all.open_conversation(visitor)) {}

  bool say(std::string_view message) { return conversation_->take(message); }
  // "" where nothing is due; "frame" and its facts, or the text. What says whether it may have
  // something done is kept apart.
  std::string next() {
    std::string text = any();
    if (text.find("\"rights\"") != std::string::npos) {
      rights_ = nlohmann::json::parse(text);
      text = any();
    }
    return text;
  }
  const nlohmann::json& rights() const { return rights_; }
  std::string ticket() const { return rights_["ticket"]; }

 private:
  std::string any() {
    std::vector<std::uint8_t> bytes{'x', 'x'};
    const std::optional<MessageKind> kind = conversation_->next(bytes);
    if (!kind) {
      EXPECT_EQ(bytes.size(), 2U);
      return "";
    }
    const std::string text(bytes.begin() + 2, bytes.end());
    return *kind == MessageKind::kText ? text : "frame " + text.substr(5, text.find(',', 5) - 5);
  }

  std::unique_ptr<Conversation> conversation_;
  nlohmann::json rights_;
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
  all_.tell(Topic::kStatus, "status");
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
  all_.tell(Topic::kStatus, "old");
  all_.tell(Topic::kStatus, "new");
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

// What a page wants is kept, to be answered later.
class ServingTest : public testing::Test {
 protected:
  std::string record(const std::string& ticket, int id = 7) {
    return R"({"do":"record","on":true,"id":)" + std::to_string(id) + R"(,"ticket":")" + ticket +
           "\"}";
  }
  nlohmann::json next_json(Reader& page) { return nlohmann::json::parse(page.next()); }

  std::vector<std::pair<Wish, Answer>> wishes_;
  std::vector<Page> pages_;  // whose they are
  int woken_ = 0;
  Broadcast all_{"hello", std::chrono::hours(1),
                 [this](const Page& page, Wish wish, Answer answer) {
                   wishes_.emplace_back(wish, answer);
                   pages_.push_back(page);
                 },
                 [this] { ++woken_; }};
};

TEST_F(ServingTest, AWishWithTheTicketOfItsPageIsServedAndAnswered) {
  Reader page(all_);
  EXPECT_EQ(page.next(), "hello");
  EXPECT_EQ(page.next(), "");
  EXPECT_EQ(page.rights()["may"], true);
  ASSERT_TRUE(page.say(record(page.ticket())));
  ASSERT_EQ(wishes_.size(), 1U);
  EXPECT_TRUE(std::get<SetRecording>(wishes_[0].first).on);
  EXPECT_EQ(page.next(), "");
  wishes_[0].second(true, "begun");
  EXPECT_EQ(woken_, 1);
  const nlohmann::json answer = next_json(page);
  EXPECT_EQ(answer["type"], "answer");
  EXPECT_EQ(answer["id"], 7);
  EXPECT_EQ(answer["done"], true);
  EXPECT_EQ(answer["text"], "begun");
}

TEST_F(ServingTest, AWishWithoutItsTicketIsRefused) {
  Reader page(all_);
  Reader other(all_);
  for (Reader* const one : {&page, &other}) {
    one->next();
    one->next();
  }
  EXPECT_NE(page.ticket(), other.ticket());
  for (const std::string& ticket : {std::string(), std::string(32, '0'), other.ticket(),
                                    page.ticket().substr(1), page.ticket() + "0"}) {
    ASSERT_TRUE(page.say(record(ticket)));
    EXPECT_EQ(next_json(page)["done"], false);
  }
  EXPECT_TRUE(wishes_.empty());
}

TEST_F(ServingTest, APageThatMayNotIsToldWhyAndGetsNoTicket) {
  Reader page(all_, {.why_not = "it is elsewhere"});
  page.next();
  page.next();
  EXPECT_EQ(page.rights()["may"], false);
  EXPECT_EQ(page.rights()["why"], "it is elsewhere");
  EXPECT_EQ(page.ticket(), "");
  ASSERT_TRUE(page.say(record("")));
  EXPECT_EQ(next_json(page)["text"], "it is elsewhere");
  EXPECT_TRUE(wishes_.empty());
}

TEST_F(ServingTest, WhoServesKnowsWhichConnectionAsksAndWhetherItIsThere) {
  std::optional<Reader> page(std::in_place, all_);
  Reader other(all_, {.place = "192.0.2.7"});
  for (Reader* const one : {&*page, &other}) {
    one->next();
    one->next();
    ASSERT_TRUE(one->say(record(one->ticket())));
  }
  ASSERT_EQ(pages_.size(), 2U);
  EXPECT_EQ(pages_[0].place, "this computer");
  EXPECT_EQ(pages_[1].place, "192.0.2.7");
  EXPECT_NE(pages_[0].number, pages_[1].number);
  EXPECT_EQ(page->rights()["page"], pages_[0].number);
  EXPECT_EQ(other.rights()["page"], pages_[1].number);
  EXPECT_TRUE(pages_[0].connected());
  page.reset();
  EXPECT_FALSE(pages_[0].connected());
  EXPECT_TRUE(pages_[1].connected());
  // Who comes again is another one.
  Reader again(all_);
  again.next();
  again.next();
  EXPECT_NE(again.rights()["page"], pages_[0].number);
}

TEST_F(ServingTest, APageThatMayNotPairDoesAllElse) {
  Reader page(all_, {.why_not_pair = "it is elsewhere", .place = "192.0.2.7"});
  page.next();
  page.next();
  EXPECT_EQ(page.rights()["may"], true);
  EXPECT_EQ(page.rights()["why_not_pair"], "it is elsewhere");
  const std::string end = R"(,"id":7,"ticket":")" + page.ticket() + "\"}";
  for (const std::string& wish :
       {R"({"do":"pair","code":"","role":"admin")" + end,
        R"({"do":"digits","digits":"123456")" + end, R"({"do":"end_pairing")" + end}) {
    ASSERT_TRUE(page.say(wish));
    const nlohmann::json answer = next_json(page);
    EXPECT_EQ(answer["done"], false);
    EXPECT_EQ(answer["text"], "it is elsewhere");
  }
  EXPECT_TRUE(wishes_.empty());
  ASSERT_TRUE(page.say(record(page.ticket())));
  EXPECT_EQ(wishes_.size(), 1U);
}

TEST_F(ServingTest, AtMostEightWishesAreOpen) {
  Reader page(all_);
  page.next();
  page.next();
  for (int id = 0; id < Mailbox::kMostOpen; ++id) {
    ASSERT_TRUE(page.say(record(page.ticket(), id)));
    EXPECT_EQ(page.next(), "");
  }
  ASSERT_TRUE(page.say(record(page.ticket(), 8)));
  EXPECT_EQ(next_json(page)["done"], false);
  EXPECT_EQ(wishes_.size(), 8U);
  wishes_[0].second(true, "");
  page.next();
  ASSERT_TRUE(page.say(record(page.ticket(), 9)));
  EXPECT_EQ(wishes_.size(), 9U);
}

TEST_F(ServingTest, WhoAsksWithoutEndIsCutOff) {
  Reader page(all_);
  int taken = 0;
  while (taken < 1'000'000 && page.say(record(""))) {
    ++taken;
  }
  EXPECT_GE(taken, 20);  // at once
  EXPECT_LT(taken, 1'000'000);
}

TEST_F(ServingTest, AnAnswerForAPageThatHasGoneIsNobodys) {
  {
    Reader page(all_);
    page.next();
    page.next();
    ASSERT_TRUE(page.say(record(page.ticket())));
  }
  wishes_[0].second(true, "");
  EXPECT_EQ(woken_, 0);
}

TEST(RateLimitTest, GivesSoManyAtOnceAndThenOneEachSoOften) {
  using std::chrono::milliseconds;
  RateLimit limit(3, milliseconds(10));
  const RateLimit::Clock::time_point start{std::chrono::hours(1)};
  EXPECT_TRUE(limit.take(start) && limit.take(start) && limit.take(start));
  EXPECT_FALSE(limit.take(start));
  EXPECT_FALSE(limit.take(start + milliseconds(9)));
  EXPECT_TRUE(limit.take(start + milliseconds(10)));
  EXPECT_FALSE(limit.take(start + milliseconds(10)));
  const auto later = start + std::chrono::hours(1);
  EXPECT_TRUE(limit.take(later) && limit.take(later) && limit.take(later));
  EXPECT_FALSE(limit.take(later));
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
