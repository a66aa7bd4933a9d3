#include "host/cli/view/page_calibration.h"

#include <chrono>
#include <condition_variable>
#include <fstream>
#include <memory>
#include <mutex>

#include <gtest/gtest.h>

#include "tests/dataset/scratch.h"

namespace stof::host {
namespace {

constexpr std::chrono::seconds kEnough{60};

// A program in the place of `stof`, and what the page is told.
class CalibrationPanel : public ::stof::test::Scratch {
 protected:
  void stand_in(const std::string& script) {
    const std::filesystem::path file = folder() / "stof";
    std::ofstream(file) << "#!/bin/sh\n" << script;
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  }
  std::unique_ptr<PageCalibration> panel(const std::string& absence = "") {
    CalibrationOptions options{
        .folder = folder(), .program = (folder() / "stof").string(), .absence = absence};
    options.config.keys = (folder() / "keys").string();
    options.config.timeout_s = 0.05;
    return std::make_unique<PageCalibration>(options, [this](const viewer::CalibrationState& told) {
      const std::scoped_lock lock(mutex_);
      told_ = told;
      news_.notify_all();
    });
  }
  // What was told last, once it is as wanted: nothing may come after it by itself.
  template <typename Wanted>
  viewer::CalibrationState until(const Wanted& wanted) {
    std::unique_lock lock(mutex_);
    EXPECT_TRUE(news_.wait_for(lock, kEnough, [&] { return wanted(told_); }))
        << told_.step << ": " << told_.text;
    return told_;
  }
  viewer::CalibrationState until(const char* step) {
    return until([&](const viewer::CalibrationState& told) { return told.step == step; });
  }

  // Nobody answers there.
  ShownSensor sensor_{.address = "127.0.0.1:9", .device = 7, .unpaired = true, .told = true};
  std::shared_ptr<int> there_ = std::make_shared<int>();  // the connection of page_
  const std::shared_ptr<int> other_there_ = std::make_shared<int>();
  const viewer::Page page_{.number = 1, .place = "this computer", .there = there_};
  const viewer::Page other_{.number = 2, .place = "192.0.2.7", .there = other_there_};

 private:
  std::mutex mutex_;
  std::condition_variable news_;
  viewer::CalibrationState told_;
};

TEST_F(CalibrationPanel, WhatTheProgramLacksIsOneLine) {
  const auto calibration = panel("no such packages");
  const auto done = calibration->begin(page_, sensor_, {.board = "9x6:0.06"});
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error(), "calibration: no such packages");
  calibration->read(sensor_);
  EXPECT_EQ(until("none").problem, "calibration: no such packages");
}

TEST_F(CalibrationPanel, LinesOfTheProgramArePassedOnUntilItsResult) {
  stand_in(
      // Keys are for signed streams, which nobody asks of a sensor that is not paired.
      "for word; do last=$word; case $word in *rig.cal) echo cal > $word;; --key*) exit 2;; esac; "
      "done\n"
      "echo '{\"state\": \"subscribing\", \"text\": \"a\"}'\n"
      "echo 'no JSON'\n"
      "echo '{\"state\": \"looking\", \"text\": \"b\", \"views\": 3}'\n"
      "echo '{\"state\": \"calibrated\", \"text\": \"c\", \"result\": {\"views\": 20}}'\n");
  const auto calibration = panel();
  EXPECT_FALSE(calibration->install(page_, sensor_));  // nothing was made
  ASSERT_TRUE(calibration->begin(page_, sensor_, {.board = "9x6:0.06"}));
  const viewer::CalibrationState made = until([](const viewer::CalibrationState& told) {
    return told.step == "calibrated" && told.text != "c";
  });
  EXPECT_EQ(made.result, "{\"views\":20}");
  EXPECT_NE(made.text.find("rig.cal is written"), std::string::npos) << made.text;
  EXPECT_TRUE(made.look.empty());
  // What is no calibration, or cannot be sent, is one line, and the file can be installed later.
  ASSERT_TRUE(calibration->install(page_, sensor_));
  const viewer::CalibrationState refused = until(
      [](const viewer::CalibrationState& told) { return told.wrong && told.step == "calibrated"; });
  EXPECT_NE(refused.text.find("rig.cal"), std::string::npos) << refused.text;
}

TEST_F(CalibrationPanel, ThePageThatBeganItAloneEndsIt) {
  stand_in(
      "trap 'echo \"stof: stopped\" >&2; exit 1' INT\n"
      "echo '{\"state\": \"looking\", \"text\": \"b\"}'\n"
      "while :; do sleep 0.05; done\n");
  const auto calibration = panel();
  EXPECT_FALSE(calibration->end(page_));
  ASSERT_TRUE(calibration->begin(page_, sensor_, {.board = "9x6:0.06"}));
  until("looking");
  EXPECT_EQ(calibration->begin(page_, sensor_, {.board = "9x6:0.06"}).error(),
            "a calibration is under way: the page that began it may end it");
  EXPECT_EQ(
      calibration->end(other_).error(),
      "another page, of this computer, began this: only that page goes on with it or ends it");
  ASSERT_TRUE(calibration->end(page_));
  EXPECT_EQ(until("ended").text, "stopped");
}

TEST_F(CalibrationPanel, EndsWithThePageThatBeganItAndKeepsNobodyOut) {
  stand_in("trap 'exit 1' INT\necho '{\"state\": \"looking\"}'\nwhile :; do sleep 0.05; done\n");
  const auto calibration = panel();
  ASSERT_TRUE(calibration->begin(page_, sensor_, {.board = "9x6:0.06"}));
  EXPECT_EQ(until("looking").by.page, page_.number);
  there_.reset();
  EXPECT_EQ(until("ended").text,
            "the page that began the calibration was closed: its views are kept");
  calibration->read(sensor_);
  EXPECT_EQ(until([](const viewer::CalibrationState& told) { return told.by.page == 0; }).step,
            "ended");
  ASSERT_TRUE(calibration->begin(other_, sensor_, {.board = "9x6:0.06"}));
  EXPECT_EQ(until("looking").by.place, "192.0.2.7");
}

TEST_F(CalibrationPanel, ThePageThatMadeItInstallsItAndOnceItHasGoneAnyOther) {
  stand_in("echo '{\"state\": \"calibrated\", \"result\": {}}'\n");
  const auto calibration = panel();
  ASSERT_TRUE(calibration->begin(page_, sensor_, {.board = "9x6:0.06"}));
  until([](const viewer::CalibrationState& told) { return told.text.ends_with("is written"); });
  EXPECT_EQ(calibration->install(other_, sensor_).error(),
            "another page, of this computer, made this calibration: only that page installs it");
  there_.reset();
  ASSERT_TRUE(calibration->install(other_, sensor_));
  const viewer::CalibrationState refused = until(
      [](const viewer::CalibrationState& told) { return told.wrong && told.step == "calibrated"; });
  EXPECT_EQ(refused.by.page, other_.number);
}

TEST_F(CalibrationPanel, AFailureIsTheProgramsOwnLineAndItEndsWithThePage) {
  stand_in("echo 'a warning' >&2; echo 'stof: no raw pictures came' >&2; exit 1\n");
  auto calibration = panel();
  ASSERT_TRUE(calibration->begin(page_, sensor_, {.board = "9x6:0.06"}));
  EXPECT_EQ(until("failed").text, "no raw pictures came");
  stand_in("trap 'exit 1' INT\necho '{\"state\": \"looking\"}'\nwhile :; do sleep 0.05; done\n");
  ASSERT_TRUE(calibration->begin(page_, sensor_, {.board = "9x6:0.06"}));
  until("looking");
  calibration.reset();  // does not wait for what never ends by itself
}

TEST_F(CalibrationPanel, AnUnfinishedCalibrationOfThisSensorGoesOn) {
  const std::filesystem::path before = folder() / "calibration_00000007_20261101_120000";
  for (const char* const view : {"a", "b"}) {
    std::filesystem::create_directories(before / "views" / view);
    std::ofstream(before / "views" / view / "left.pgm") << "P5";
  }
  stand_in("exit 1\n");
  const auto calibration = panel();
  calibration->read(sensor_);
  EXPECT_EQ(until("none").kept, 2U);
  ASSERT_TRUE(calibration->begin(page_, sensor_, {.board = "9x6:0.06", .goes_on = true}));
  EXPECT_EQ(until("failed").folder, before.string());
}

}  // namespace
}  // namespace stof::host
