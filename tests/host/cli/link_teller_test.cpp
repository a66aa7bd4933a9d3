#include "host/cli/live/link_teller.h"

#include <chrono>
#include <vector>

#include <gtest/gtest.h>

namespace stof::host {
namespace {

using namespace std::chrono_literals;

client::LinkState heard(client::Duration frame_age, client::Duration health_age) {
  return {.silent = false, .frame_age = frame_age, .health_age = health_age};
}

client::LinkState silent() {
  client::LinkState link = heard(400ms, 900ms);
  link.silent = true;
  return link;
}

constexpr client::Time kStart{};
const std::optional<wire::HealthReport> kGood{wire::HealthReport{}};

TEST(LinkTeller, TellsSilenceOnceWithTheAgeOfTheLastHealth) {
  LinkTeller teller;
  EXPECT_EQ(teller.look(heard(10ms, 200ms), kGood, kStart), "");
  EXPECT_EQ(teller.look(silent(), kGood, kStart),
            "link: the sensor is silent, its last frame is 0.4 s old; last health 0.9 s ago: good");
  EXPECT_EQ(teller.look(silent(), kGood, kStart), "");
  EXPECT_EQ(teller.look(heard(10ms, 200ms), kGood, kStart), "");
  EXPECT_EQ(teller.look(heard(10ms, 200ms), kGood, kStart + 999ms), "");
  EXPECT_EQ(teller.look(heard(10ms, 200ms), kGood, kStart + 1s), "link: the sensor sends again");
  EXPECT_EQ(teller.look(heard(10ms, 200ms), kGood, kStart + 2s), "");
  EXPECT_EQ(teller.silences(), 1U);
  EXPECT_EQ(teller.restarts(), 0U);
}

TEST(LinkTeller, TellsARestartOnceAndThatThereIsNoHealthYet) {
  LinkTeller teller;
  EXPECT_EQ(teller.look(heard(10ms, 200ms), kGood, kStart), "");
  client::LinkState again{.silent = false, .restarted = true, .frame_age = 5ms};
  EXPECT_EQ(teller.look(again, {}, kStart), "link: the sensor started again; no health of it yet");
  EXPECT_EQ(teller.look(again, {}, kStart), "");
  EXPECT_EQ(teller.look(heard(10ms, 200ms), kGood, kStart), "");
  EXPECT_EQ(teller.look(again, kGood, kStart),
            "link: the sensor started again; no health of it yet");
  EXPECT_EQ(teller.restarts(), 2U);
}

TEST(LinkTeller, TellsForgedTrafficWhenItBegins) {
  LinkTeller teller;
  client::LinkState link = heard(10ms, 200ms);
  EXPECT_EQ(teller.look(link, kGood, kStart), "");
  for (int time = 0; time < 2; ++time) {
    link.forged_traffic = true;
    EXPECT_TRUE(teller.look(link, kGood, kStart).starts_with("link: forged traffic"));
    ASSERT_EQ(teller.changes().size(), 1U);
    EXPECT_STREQ(teller.changes().front().state, "forged_traffic");
    EXPECT_EQ(teller.look(link, kGood, kStart), "");
    link.forged_traffic = false;
    EXPECT_EQ(teller.look(link, kGood, kStart), "");
  }
}

TEST(LinkTeller, TellsGapAfterGapInTwoLines) {
  LinkTeller teller;
  client::Time now = kStart;
  EXPECT_NE(teller.look(silent(), kGood, now), "");
  for (int gap = 0; gap < 3; ++gap) {
    EXPECT_EQ(teller.look(heard(10ms, 200ms), kGood, now += 900ms), "");
    EXPECT_EQ(teller.look(silent(), kGood, now += 900ms), "");
  }
  EXPECT_EQ(teller.look(heard(10ms, 200ms), kGood, now += 10s), "");
  EXPECT_EQ(teller.look(heard(10ms, 200ms), kGood, now += 1s),
            "link: the sensor sends again, it was silent 3 times more");
  EXPECT_EQ(teller.silences(), 4U);
  EXPECT_NE(teller.look(silent(), kGood, now), "");
  EXPECT_EQ(teller.look(heard(10ms, 200ms), kGood, now), "");
  EXPECT_EQ(teller.look(heard(10ms, 200ms), kGood, now + 1s), "link: the sensor sends again");
}

TEST(LinkTeller, TellsBothAtOnceInTwoLines) {
  LinkTeller teller;
  client::LinkState both = silent();
  static_cast<void>(teller.look(heard(10ms, 200ms), kGood, kStart));
  both.restarted = true;
  EXPECT_EQ(teller.look(both, kGood, kStart),
            "link: the sensor started again; last health 0.9 s ago: good\n"
            "link: the sensor is silent, its last frame is 0.4 s old; last health 0.9 s ago: good");
  const std::vector<LinkTeller::Change> changes = teller.changes();
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_EQ(changes[0].text, "link: the sensor started again; last health 0.9 s ago: good");
  EXPECT_EQ(changes[0].severity, wire::Severity::kMinor);
  EXPECT_EQ(changes[1].severity, wire::Severity::kMajor);
  EXPECT_TRUE(changes[0].active && changes[1].active);
  static_cast<void>(teller.look(heard(10ms, 200ms), kGood, kStart));
  EXPECT_TRUE(teller.changes().empty());
  static_cast<void>(teller.look(heard(10ms, 200ms), kGood, kStart + 1s));
  ASSERT_EQ(teller.changes().size(), 1U);
  EXPECT_FALSE(teller.changes()[0].active);
}

TEST(LinkTeller, TellsNothingOfASensorThatNeverCame) {
  LinkTeller teller;
  EXPECT_EQ(teller.look({.silent = false}, {}, kStart), "");
  EXPECT_EQ(teller.look({.silent = true}, {}, kStart), "");
  EXPECT_EQ(teller.silences(), 0U);
}

TEST(LinkTeller, TellsForgedTrafficBeforeAnyFrameOrHealth) {
  LinkTeller teller;
  EXPECT_NE(teller.look({.silent = true, .forged_traffic = true}, {}, kStart), "");
  EXPECT_EQ(teller.changes().back().state, std::string("forged_traffic"));
}

TEST(LinkTeller, TellsSilenceOfASensorThatOnlyToldItsHealth) {
  LinkTeller teller;
  EXPECT_EQ(teller.look({.silent = true, .health_age = 100ms}, kGood, kStart),
            "link: no frame came yet; last health 0.1 s ago: good");
  EXPECT_EQ(teller.look(heard(10ms, 200ms), kGood, kStart + 100ms), "");
  EXPECT_EQ(teller.look(heard(10ms, 200ms), kGood, kStart + 1100ms), "link: frames come");
}

}  // namespace
}  // namespace stof::host
