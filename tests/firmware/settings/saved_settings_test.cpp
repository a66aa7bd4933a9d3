#include "firmware/settings/saved_settings.h"

#include <array>
#include <chrono>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/settings/depth_settings.h"
#include "firmware/settings/fields/document.h"
#include "firmware/settings/settings_trial.h"
#include "hal/emu/devices/store.h"

namespace stof::settings {
namespace {

using namespace std::chrono_literals;

class Board final : public Limits {
 public:
  bool accepts(const Settings& settings, PagedWriter& why) noexcept override {
    if (settings.depth.disparities > 128) {
      why << "too many disparities";
      return false;
    }
    return true;
  }
};

void put(hal::emu::Store& store, const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  store.bytes().assign(bytes.begin(), bytes.end());
}

Settings named(const std::string& name) {
  Settings settings;
  settings.name = Text<kNameBytes + 1>(name);
  return settings;
}

// A sensor's medium, and starts from it.
struct Medium {
  hal::emu::Store current;
  hal::emu::Store good;
  hal::emu::Store trial;
  Board board;
  std::string told;  // at the last start

  SettingsStores stores() { return {current, good, trial}; }
  StartSettings start() {
    std::array<char, 320> space;
    PagedWriter line(space);
    const StartSettings start = load_settings(stores(), "x.json", &board, line);
    told = line.text();
    return start;
  }
  // A start with them that publishes for so long.
  StartSettings run(hal::Duration time) {
    const StartSettings begun = start();
    if (begun.on_trial) {
      SettingsTrial proof(stores(), begun.settings, false);
      proof.tick(hal::Time(100s), 1, &begun.settings);
      proof.tick(hal::Time(100s) + time, 2, &begun.settings);
    }
    return begun;
  }
};

TEST(SavedSettings, ThatCannotBeUsedAreSetAsideAndTold) {
  const std::vector<std::pair<std::string, std::string>> damaged{
      {"{\"name\": \"a\"", "x.json: not JSON: it ends too early"},
      {"{\"name\": \"a\", \"new_field\": 1}", "x.json: \"new_field\": there is no such setting"},
      {"{\"depth\": {\"disparities\": 200}}", "x.json: too many disparities"},
      {std::string(40'000, ' '), "x.json: longer than"}};
  for (const auto& [text, told] : damaged) {
    Medium medium;
    put(medium.current, text);
    const StartSettings start = medium.start();
    EXPECT_EQ(start.settings, Settings{});
    EXPECT_EQ(start.dropped, Dropped::kUnusable);
    EXPECT_TRUE(medium.told.starts_with(told)) << medium.told;
    EXPECT_TRUE(medium.told.ends_with(": the defaults hold, the file is kept as .bad"))
        << medium.told;
    EXPECT_EQ(medium.current.aside().size(), text.size());
    EXPECT_EQ(medium.start().settings, Settings{});
    EXPECT_EQ(medium.told, "");
  }
}

TEST(SavedSettings, MayNameSomeFieldsOnly) {
  Medium medium;
  put(medium.current, "{\"name\": \"a\"}\n");
  EXPECT_EQ(medium.start().settings, named("a"));
}

Settings loaded(const std::string& text, std::string& told, bool& fell_back) {
  Medium medium;
  put(medium.current, text);
  const StartSettings start = medium.start();
  told = medium.told;
  fell_back = start.fell_back;
  EXPECT_TRUE(medium.current.aside().empty());
  return start.settings;
}

TEST(SavedSettings, ThatNameWhatLeftKeepAllOtherFields) {
  for (const auto& [name, value] :
       std::vector<std::pair<std::string, std::string>>{{"method", "\"dp\""},
                                                        {"cost", "\"ssd\""},
                                                        {"shape", "\"cross\""},
                                                        {"directions", "8"},
                                                        {"band", "3"},
                                                        {"pyramid", "2"},
                                                        {"interest", "\"maxima\""},
                                                        {"penalties", "\"12,40,6\""},
                                                        {"penalties", "\"10,60\""}}) {
    std::string told;
    bool fell_back = false;
    const Settings settings = loaded(
        "{\"name\": \"a\", \"depth\": {\"match\": {\"" + name + "\": " + value + ", \"lr\": 2}}}",
        told, fell_back);
    EXPECT_TRUE(fell_back) << name;
    EXPECT_EQ(told, "x.json: depth.match." + name + ": not in this version: as the preset has it");
    EXPECT_EQ(settings.name.view(), "a");
    EXPECT_EQ(depth_params(settings, 64).match.left_right_tolerance, 2);
    EXPECT_EQ(depth_params(settings, 64).match.search, dsp::Search::kBlocks);
    EXPECT_FALSE(depth_params(settings, 64).match.smoothness);
  }
}

TEST(SavedSettings, OfBlocksThatAreNotMatchedAnyMoreFallBack) {
  std::string told;
  bool fell_back = false;
  Settings settings =
      loaded(R"({"depth": {"match": {"prefilter": "off", "texture": "off", "block": "9x9"}}})",
             told, fell_back);
  EXPECT_EQ(told,
            "x.json: depth.match.prefilter: sums of such blocks do not fit 16 bits: as the preset "
            "has it");
  EXPECT_EQ(depth_params(settings, 64).match.prefilter_cap, 15);
  EXPECT_EQ(depth_params(settings, 64).match.block_width, 9);
  settings = loaded(R"({"depth": {"match": {"block": "21x21"}}})", told, fell_back);
  EXPECT_EQ(
      told,
      "x.json: depth.match.block: sums of such blocks do not fit 16 bits: as the preset has it");
  EXPECT_EQ(depth_params(settings, 64).match.block_width, 14);
  settings =
      loaded(R"({"depth": {"preset": "quality", "match": {"block": "21x21"}}})", told, fell_back);
  EXPECT_EQ(told, "");
  EXPECT_FALSE(fell_back);
  EXPECT_EQ(depth_params(settings, 64).match.block_width, 21);
}

// As an earlier version wrote every file: all fields, most of them as the preset has them.
TEST(SavedSettings, WhoseFieldsThatLeftSayPresetHaveNothingToTell) {
  std::string told;
  bool fell_back = true;
  const Settings settings =
      loaded(R"({"depth": {"match": {"method": "preset", "cost": "preset", "shape": "preset",
          "directions": "preset", "band": "preset", "pyramid": "preset", "interest": "preset",
          "speckle": 30}}})",
             told, fell_back);
  EXPECT_EQ(told, "");
  EXPECT_FALSE(fell_back);
  EXPECT_EQ(depth_params(settings, 64).match.speckle_pixels, 30);
}

TEST(SavedSettings, ThatNameAllThatLeftAreToldOfEach) {
  std::string told;
  bool fell_back = false;
  loaded(R"({"depth": {"match": {"method": "dp", "cost": "ssd", "shape": "cross", "directions": 8,
          "band": 3, "pyramid": 2, "interest": "maxima"}}})",
         told, fell_back);
  EXPECT_EQ(told,
            "x.json: depth.match.method: not in this version: as the preset has it; "
            "depth.match.cost too; depth.match.shape too; depth.match.directions too; "
            "depth.match.band too; depth.match.pyramid too; depth.match.interest too");
}

TEST(SavedSettings, ThatAreEmptyAreToldAndSetAside) {
  Medium medium;
  put(medium.current, "");
  EXPECT_EQ(medium.start().dropped, Dropped::kEmpty);
  EXPECT_EQ(medium.told, "x.json: empty: the defaults hold, the file is kept as .bad");
  EXPECT_EQ(Medium().start().dropped, Dropped::kNot) << "nothing was ever saved";
}

TEST(SavedSettings, ThatAreNoFileOrUnreadableStayWhereTheyAre) {
  for (const auto& [status, dropped, told] :
       {std::tuple(Status::kUnsupported, Dropped::kNoFile, "no regular file, it is left alone"),
        std::tuple(Status::kDeviceError, Dropped::kUnreadable,
                   "cannot be read, it is left alone")}) {
    Medium medium;
    put(medium.current, "{\"name\": \"a\"}");
    medium.current.break_down(true, status);
    const StartSettings start = medium.start();
    EXPECT_EQ(start.dropped, dropped);
    EXPECT_EQ(start.settings, Settings{});
    EXPECT_EQ(medium.told, std::string("x.json: ") + told + ": the defaults hold");
    medium.current.break_down(false);
    EXPECT_EQ(medium.start().settings, named("a"));
  }
}

TEST(SavedSettings, ProvenOnesAreTheLastGoodAndWriteNothingMore) {
  Medium medium;
  ASSERT_EQ(save_document(medium.current, named("a")), Status::kOk);
  EXPECT_TRUE(medium.run(SettingsTrial::kProof - 1ns).on_trial);
  EXPECT_TRUE(medium.run(SettingsTrial::kProof).on_trial);
  const int written = medium.good.saves() + medium.trial.saves();
  for (int i = 0; i < 10; ++i) {
    const StartSettings start = medium.run(SettingsTrial::kProof);
    EXPECT_FALSE(start.on_trial);
    EXPECT_EQ(start.settings, named("a"));
  }
  EXPECT_EQ(medium.good.saves() + medium.trial.saves(), written);
  EXPECT_EQ(medium.current.saves(), 1);
}

TEST(SavedSettings, TwoFailedStartsBringTheLastGoodOnesBack) {
  Medium medium;
  ASSERT_EQ(save_document(medium.current, named("good")), Status::kOk);
  medium.run(SettingsTrial::kProof);
  ASSERT_EQ(save_document(medium.current, named("bad")), Status::kOk);
  for (int i = 0; i < kMaxFailedStarts; ++i) {
    EXPECT_EQ(medium.run(1s).settings, named("bad"));
  }
  const int written = medium.trial.saves();
  for (int i = 0; i < 3; ++i) {  // and again, without wear
    const StartSettings start = medium.run(1s);
    EXPECT_EQ(start.settings, named("good"));
    EXPECT_EQ(start.dropped, Dropped::kFailedStarts);
    EXPECT_TRUE(start.good);
    EXPECT_EQ(medium.told,
              "x.json: two starts with these settings have failed: the last good settings hold");
  }
  EXPECT_EQ(medium.trial.saves(), written);
  ASSERT_EQ(save_document(medium.current, named("better")), Status::kOk);
  EXPECT_EQ(medium.run(1s).settings, named("better")) << "a change begins anew";
}

TEST(SavedSettings, AStartThatCannotBeCountedIsTold) {
  Medium medium;
  ASSERT_EQ(save_document(medium.current, named("new")), Status::kOk);
  medium.trial.break_down(true, Status::kUnsupported);  // a folder in its place
  EXPECT_EQ(medium.start().settings, named("new"));
  EXPECT_EQ(medium.told,
            "x.json.trial: cannot be written: starts that fail with these settings are not "
            "counted, so the last good "
            "ones will not come back: make it a file, or remove it");
  medium.trial.break_down(false);
  medium.start();
  EXPECT_EQ(medium.told, "");
}

TEST(SavedSettings, DamagedOrMissingOnesAreReplacedByTheLastGood) {
  for (const char* const text : {"{", "", R"({"depth": {"disparities": 200}})"}) {
    Medium medium;
    ASSERT_EQ(save_document(medium.current, named("good")), Status::kOk);
    medium.run(SettingsTrial::kProof);
    put(medium.current, text);
    EXPECT_EQ(medium.start().settings, named("good"));
    const StartSettings next = medium.start();  // it was set aside
    EXPECT_EQ(next.settings, named("good"));
    EXPECT_EQ(next.dropped, Dropped::kMissing);
  }
}

// What somebody put on the card before the first start.
TEST(SavedSettings, TheFirstOnesAreTakenWhereNoneWereSaved) {
  constexpr std::string_view kFirst = R"({"name": "front", "network": {"dhcp": false}})";
  const auto told = [](Medium& medium, hal::emu::Store& fixed, std::string_view text) {
    std::array<char, 512> space;
    PagedWriter line(space);
    const SettingsStores stores{medium.current, medium.good, medium.trial, &fixed};
    save_first(stores, text, "settings.json", line);
    const StartSettings start = load_settings(stores, "x", nullptr, line);
    EXPECT_EQ(start.dropped, Dropped::kNot) << line.text();
    return std::pair(std::string(line.text()), start.settings);
  };
  Medium medium;
  hal::emu::Store fixed;
  const auto [line, first] = told(medium, fixed, kFirst);
  EXPECT_EQ(line, "settings.json: taken as the first settings");
  EXPECT_EQ(first.name.view(), "front");
  EXPECT_FALSE(first.network.dhcp);
  const auto [again, kept] = told(medium, fixed, R"({"name": "other"})");
  EXPECT_EQ(again, "");
  EXPECT_EQ(kept, first);
  for (const char* const wrong : {"", "{", R"({"colour": 1})", R"({"network": {"address": "x"}})",
                                  R"({"network": {"dhcp": false, "link_local": false}})"}) {
    Medium empty;
    hal::emu::Store none;
    const auto [why, defaults] = told(empty, none, wrong);
    EXPECT_TRUE(why.starts_with("settings.json: ")) << why;
    EXPECT_TRUE(why.ends_with(": none of it is taken")) << why;
    EXPECT_EQ(why.find('\n'), std::string::npos);
    EXPECT_EQ(defaults, Settings{});
    EXPECT_EQ(empty.current.saves(), 0);
  }
}

// What an installer fixed is as strict as it was, whatever becomes of the settings.
TEST(SavedSettings, DroppedOnesLeaveWhatAnInstallerFixed) {
  Settings saved = named("a");
  saved.serial.remote = true;
  saved.limits = {.least_range_mm = 4000,
                  .least_period_ms = 40,
                  .most_period_ms = 200,
                  .streams = StreamLimit::kFixed};
  for (const bool with_good : {false, true}) {
    Medium medium;
    hal::emu::Store fixed;
    const auto start = [&] {
      std::array<char, 320> space;
      PagedWriter line(space);
      SettingsStores stores = medium.stores();
      stores.fixed = &fixed;
      const StartSettings started = load_settings(stores, "x.json", &medium.board, line);
      medium.told = line.text();
      return started;
    };
    if (with_good) {  // from before the limits
      ASSERT_EQ(save_document(medium.good, named("old")), Status::kOk);
    }
    ASSERT_EQ(save_document(medium.current, saved), Status::kOk);
    EXPECT_EQ(start().settings, saved);
    EXPECT_EQ(fixed.saves(), 1);
    // Two starts that failed, then a damaged file, then none.
    EXPECT_EQ(start().dropped, Dropped::kNot);
    EXPECT_EQ(fixed.saves(), 1);
    std::vector<StartSettings> dropped{start()};
    put(medium.current, "{");
    dropped.push_back(start());
    dropped.push_back(start());
    for (const StartSettings& fallback : dropped) {
      EXPECT_NE(fallback.dropped, Dropped::kNot);
      EXPECT_EQ(fallback.good, with_good);
      EXPECT_EQ(fallback.settings.name.view(), with_good ? "old" : "stof");
      EXPECT_TRUE(fallback.settings.serial.remote);
      EXPECT_EQ(fallback.settings.limits, saved.limits);
      EXPECT_FALSE(fallback.strictest);
    }
  }
}

TEST(SavedSettings, WhereNobodyKnowsWhatWasFixedTheStrictestHolds) {
  constexpr const char* kNamesMore =
      R"({"name": "x", "serial": {"remote": false}, "limits": {"least_range_mm": 500, )"
      R"("least_period_ms": 0, "most_period_ms": 1000, "streams": "none"}})";
  for (const char* const record : {"", "{", "{}", R"({"serial": {"remote": false}})", kNamesMore}) {
    Medium medium;
    hal::emu::Store fixed;
    put(fixed, record);
    put(medium.current, "{");
    std::array<char, 320> space;
    PagedWriter line(space);
    const StartSettings started =
        load_settings({medium.current, medium.good, medium.trial, &fixed}, "x.json", nullptr, line);
    EXPECT_TRUE(started.strictest) << record;
    EXPECT_TRUE(started.settings.serial.remote);
    EXPECT_EQ(started.settings.limits.streams, StreamLimit::kFixed);
    EXPECT_GT(started.settings.limits.least_period_ms, started.settings.limits.most_period_ms);
    EXPECT_NE(line.text().find("with the strictest limits"), std::string_view::npos) << line.text();
  }
}

// Settings that are gone, and limits that cannot be read any more, are no sensor that is new.
TEST(SavedSettings, MissingOnesBesideLimitsThatAreDamagedAreTold) {
  Medium medium;
  hal::emu::Store fixed;
  std::array<char, 320> space;
  PagedWriter line(space);
  const SettingsStores stores{medium.current, medium.good, medium.trial, &fixed};
  EXPECT_EQ(load_settings(stores, "x.json", nullptr, line).dropped, Dropped::kNot);
  put(fixed, "{");
  const StartSettings started = load_settings(stores, "x.json", nullptr, line);
  EXPECT_EQ(started.dropped, Dropped::kMissing);
  EXPECT_TRUE(started.strictest);
  EXPECT_EQ(started.settings.limits.streams, StreamLimit::kFixed);
}

// A version before the network's settings wrote it.
TEST(SavedSettings, ARecordWithoutTheNetworkIsWhole) {
  Medium medium;
  hal::emu::Store fixed;
  put(fixed,
      R"({"serial": {"remote": false}, "limits": {"least_range_mm": 4000, "least_period_ms": 0, )"
      R"("most_period_ms": 1000, "streams": "none"}})");
  put(medium.current, "{");
  std::array<char, 320> space;
  PagedWriter line(space);
  const StartSettings started =
      load_settings({medium.current, medium.good, medium.trial, &fixed}, "x.json", nullptr, line);
  EXPECT_FALSE(started.strictest) << line.text();
  EXPECT_EQ(started.settings.limits.least_range_mm, 4000);
  EXPECT_EQ(started.settings.network, NetworkSettings{});
}

TEST(SettingsTrial, AnEndThatWasAskedForIsNoFailedStart) {
  Medium medium;
  const Settings a = named("a");
  ASSERT_EQ(save_document(medium.current, a), Status::kOk);
  for (int i = 0; i < 5; ++i) {
    SettingsTrial trial(medium.stores(), medium.start().settings, false);
    trial.tick(hal::Time(1s), 1, &a);
    trial.end(1);
  }
  EXPECT_EQ(failed_starts(medium.trial, a), 0);
  SettingsTrial blind(medium.stores(), medium.start().settings, false);
  blind.end(0);
  EXPECT_EQ(failed_starts(medium.trial, a), 1) << "nothing was published";
}

TEST(SettingsTrial, OtherSettingsOrNoFramesProveNothing) {
  Medium medium;
  const Settings a = named("a");
  ASSERT_EQ(save_document(medium.current, a), Status::kOk);
  SettingsTrial changed(medium.stores(), medium.start().settings, false);
  changed.tick(hal::Time(1s), 1, &a);
  changed.tick(hal::Time(2s), 2, nullptr);
  changed.tick(hal::Time(60s), 3, &a);
  SettingsTrial silent(medium.stores(), a, false);
  silent.tick(hal::Time(1s), 0, &a);
  silent.tick(hal::Time(60s), 0, &a);
  SettingsTrial stuck(medium.stores(), a, false);
  stuck.tick(hal::Time(1s), 1, &a);
  stuck.tick(hal::Time(60s), 1, &a);
  EXPECT_EQ(medium.good.saves(), 0);
}

TEST(SettingsTrial, WhatIsSavedWhileTheSensorRunsProvesGoodToo) {
  Medium medium;
  const Settings a = named("a");
  const Settings b = named("b");
  SettingsTrial trial(medium.stores(), a, true);
  trial.tick(hal::Time(1s), 1, &a);
  trial.tick(hal::Time(60s), 2, &a);
  EXPECT_EQ(medium.good.saves(), 0) << "they are the last good ones";
  ASSERT_EQ(save_document(medium.current, b), Status::kOk);
  trial.tick(hal::Time(61s), 3, &b);
  trial.tick(hal::Time(61s) + SettingsTrial::kProof - 1ns, 4, &b);
  EXPECT_EQ(medium.good.saves(), 0);
  trial.tick(hal::Time(61s) + SettingsTrial::kProof, 5, &b);
  trial.tick(hal::Time(90s), 6, &b);
  EXPECT_EQ(medium.good.saves(), 1);
  EXPECT_FALSE(medium.start().on_trial);
}

TEST(SettingsTrial, AnyBytesInTheRecordCountNothing) {
  for (const char* const text :
       {"", "1", "00000000 9", "zzzzzzzz 1", "0000000011", "00000000 1x"}) {
    Medium medium;
    put(medium.trial, text);
    EXPECT_EQ(failed_starts(medium.trial, named("a")), 0) << text;
  }
}

}  // namespace
}  // namespace stof::settings
