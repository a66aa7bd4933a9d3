#include "host/cli/live/link_teller.h"

#include <chrono>

#include <gtest/gtest.h>

namespace stof::host {
namespace {

using namespace std::chrono_literals;

client::LinkState heard(client::Duration frame_age, client::Duration health_age) {
  return {.silent = false, .frame_age = frame_age, .health_age = health_age};
}

const std::optional<wire::HealthReport> kGood{wire::HealthReport{}};

TEST(LinkTeller, TellsSilenceOnceWithTheAgeOfTheLastHealth) {
  LinkTeller teller;
  EXPECT_EQ(teller.look(heard(10ms, 200ms), kGood), "");
  client::LinkState silent = heard(400ms, 900ms);
  silent.silent = true;
  EXPECT_EQ(teller.look(silent, kGood),
            "link: the sensor is silent, its last frame is 0.4 s old; last health 0.9 s ago: good");
  EXPECT_EQ(teller.look(silent, kGood), "");
  EXPECT_EQ(teller.look(heard(10ms, 200ms), kGood), "link: the sensor sends again");
  EXPECT_EQ(teller.silences(), 1U);
  EXPECT_EQ(teller.restarts(), 0U);
}

TEST(LinkTeller, TellsARestartOnceAndThatThereIsNoHealthYet) {
  LinkTeller teller;
  EXPECT_EQ(teller.look(heard(10ms, 200ms), kGood), "");
  client::LinkState again{.silent = false, .restarted = true, .frame_age = 5ms};
  EXPECT_EQ(teller.look(again, {}), "link: the sensor started again; no health of it yet");
  EXPECT_EQ(teller.look(again, {}), "");
  EXPECT_EQ(teller.look(heard(10ms, 200ms), kGood), "");
  EXPECT_EQ(teller.look(again, kGood), "link: the sensor started again; no health of it yet");
  EXPECT_EQ(teller.restarts(), 2U);
}

TEST(LinkTeller, TellsBothAtOnceInTwoLines) {
  LinkTeller teller;
  client::LinkState silent = heard(400ms, 900ms);
  silent.silent = true;
  static_cast<void>(teller.look(silent, kGood));
  client::LinkState back{.silent = false, .restarted = true, .frame_age = 5ms, .health_age = 100ms};
  EXPECT_EQ(teller.look(back, kGood),
            "link: the sensor started again; last health 0.1 s ago: good\n"
            "link: the sensor sends again");
}

TEST(LinkTeller, TellsNothingOfASensorThatNeverCame) {
  LinkTeller teller;
  EXPECT_EQ(teller.look({.silent = false}, {}), "");
  EXPECT_EQ(teller.look({.silent = true}, {}), "");
  EXPECT_EQ(teller.silences(), 0U);
}

TEST(LinkTeller, TellsSilenceOfASensorThatOnlyToldItsHealth) {
  LinkTeller teller;
  EXPECT_EQ(teller.look({.silent = true, .health_age = 100ms}, kGood),
            "link: the sensor is silent, no frame came yet; last health 0.1 s ago: good");
}

}  // namespace
}  // namespace stof::host
