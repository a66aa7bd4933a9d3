// Single settings by libstof, against the appliance's own settings server.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <stof/stof.hpp>

#include "firmware/keys/authenticator.h"
#include "firmware/settings/settings_server.h"
#include "hal/emu/devices/store.h"
#include "tests/host/lib/lib_sensor.h"

namespace {

// Whatever keys this user has.
stof::Sensor open_without_keys(const stof::test::Sensor& sensor) {
  const std::string at = stof::test::endpoint(sensor);
  stof_options options = STOF_INIT(stof_options);
  options.sensor = at.c_str();
  options.keys = "";
  std::string why;
  auto opened = stof::Sensor::open(options, &why);
  if (!opened) {
    ADD_FAILURE() << why;
    std::abort();
  }
  return std::move(*opened);
}

// Nobody is paired: what is harmless may be changed.
class SettingTest : public testing::Test, stof::settings::Limits, stof::settings::SettingsSink {
 protected:
  bool accepts(const stof::settings::Settings& /*settings*/,
               stof::settings::PagedWriter& /*why*/) noexcept override {
    return true;
  }
  bool apply(const stof::settings::Settings& /*settings*/,
             std::uint32_t /*revision*/) noexcept override {
    return true;
  }

  stof::hal::emu::Store store_;
  stof::settings::SettingsServer server_{
      {}, {}, {.limits = *this, .sink = *this, .store = &store_}};
  stof::keys::Keyring ring_{nullptr, nullptr};
  stof::keys::Authenticator authenticator_{ring_};
  stof::test::Sensor sensor_{&server_, 0, 1, &authenticator_};
  stof::Sensor client_ = open_without_keys(sensor_);
};

TEST_F(SettingTest, TellsWhatASettingTakes) {
  std::string why;
  auto range = client_.setting(STOF_SETTING_MAX_RANGE_MM, &why);
  ASSERT_TRUE(range) << why;
  EXPECT_EQ(range->kind, static_cast<std::uint32_t>(STOF_SETTING_INTEGER));
  EXPECT_EQ(range->value, 10'000);
  EXPECT_EQ(range->minimum, 500);
  EXPECT_EQ(range->maximum, 16'380);
  EXPECT_EQ(range->default_value, 10'000);
  EXPECT_STREQ(range->text, "10000");
  EXPECT_STREQ(range->unit, "mm");
  EXPECT_EQ(range->at_restart, 0U);
  const auto depth = client_.setting(STOF_SETTING_STREAM_DEPTH, &why);
  ASSERT_TRUE(depth) << why;
  EXPECT_EQ(depth->kind, static_cast<std::uint32_t>(STOF_SETTING_CHOICE));
  EXPECT_STREQ(depth->choices, "off raw rvl fit");
  EXPECT_STREQ(depth->text, "fit");
  EXPECT_EQ(depth->value, 3);
  EXPECT_EQ(depth->maximum, 3);
  const auto temporal = client_.setting(STOF_SETTING_TEMPORAL, &why);
  ASSERT_TRUE(temporal) << why;
  EXPECT_EQ(temporal->kind, static_cast<std::uint32_t>(STOF_SETTING_BOOLEAN));
  EXPECT_EQ(temporal->value, 0);
  const auto name = client_.setting(STOF_SETTING_NAME, &why);
  ASSERT_TRUE(name) << why;
  EXPECT_EQ(name->kind, static_cast<std::uint32_t>(STOF_SETTING_TEXT));
  EXPECT_STREQ(name->text, "stof");
  EXPECT_EQ(client_.setting("udp.port")->at_restart, 1U);
}

TEST_F(SettingTest, EveryPathOfTheHeaderIsOne) {
  for (const char* const path :
       {STOF_SETTING_NAME, STOF_SETTING_PERIOD_MS, STOF_SETTING_MAX_RANGE_MM, STOF_SETTING_PRESET,
        STOF_SETTING_TEMPORAL, STOF_SETTING_GUIDED, STOF_SETTING_STREAM_DEPTH,
        STOF_SETTING_STREAM_WIDTH, STOF_SETTING_STREAM_SOURCE, STOF_SETTING_STREAM_DISPARITY,
        STOF_SETTING_STREAM_PMD_RAW, STOF_SETTING_STREAM_GREY_LEFT, STOF_SETTING_STREAM_GREY_RIGHT,
        STOF_SETTING_STREAM_CLOUD, STOF_SETTING_CLOUD_STEP, STOF_SETTING_PARITY}) {
    std::string why;
    EXPECT_TRUE(client_.setting(path, &why)) << path << ": " << why;
  }
}

TEST_F(SettingTest, ChangesOneByItsKind) {
  std::string why;
  EXPECT_EQ(client_.set_integer(STOF_SETTING_MAX_RANGE_MM, 8000, &why), STOF_OK) << why;
  EXPECT_EQ(client_.set_text(STOF_SETTING_STREAM_GREY_LEFT, "rvl", &why), STOF_OK) << why;
  EXPECT_EQ(client_.set_boolean(STOF_SETTING_PARITY, true, &why), STOF_OK) << why;
  EXPECT_EQ(client_.setting(STOF_SETTING_MAX_RANGE_MM)->value, 8000);
  EXPECT_STREQ(client_.setting(STOF_SETTING_STREAM_GREY_LEFT)->text, "rvl");
  EXPECT_EQ(client_.setting(STOF_SETTING_PARITY)->value, 1);
  // What it does not take comes with what it takes.
  EXPECT_EQ(client_.set_integer(STOF_SETTING_MAX_RANGE_MM, 100, &why), STOF_REFUSED);
  EXPECT_NE(why.find("takes 500 to 16380"), std::string::npos) << why;
  EXPECT_EQ(client_.set_text(STOF_SETTING_STREAM_DEPTH, "zip", &why), STOF_REFUSED);
  EXPECT_NE(why.find("off, raw, rvl or fit"), std::string::npos) << why;
  EXPECT_EQ(client_.setting(STOF_SETTING_MAX_RANGE_MM)->value, 8000);
}

TEST_F(SettingTest, WhatNoSettingCanBeIsRefusedHere) {
  std::string why;
  for (const char* const path : {"", ".", "a..b", "depth.", "depth.max range", "depth.\"x", "x{"}) {
    EXPECT_EQ(client_.set_integer(path, 1, &why), STOF_BAD_ARGUMENT) << path;
    EXPECT_FALSE(client_.setting(path, &why)) << path;
    EXPECT_NE(why, "") << path;
  }
  for (const char* const path : {"depth.moon", "depth", "moon"}) {
    EXPECT_FALSE(client_.setting(path, &why)) << path;
    EXPECT_NE(why.find("no such setting"), std::string::npos) << why;
  }
  EXPECT_EQ(client_.set_text(STOF_SETTING_NAME, "a\"b", &why), STOF_BAD_ARGUMENT);
  EXPECT_EQ(stof_set_text(client_.c(), STOF_SETTING_NAME, nullptr, nullptr, 0), STOF_BAD_ARGUMENT);
  EXPECT_EQ(stof_get_setting(client_.c(), STOF_SETTING_NAME, nullptr, nullptr, 0),
            STOF_BAD_ARGUMENT);
  EXPECT_EQ(stof_set_boolean(nullptr, STOF_SETTING_PARITY, 1, nullptr, 0), STOF_BAD_ARGUMENT);
}

}  // namespace
