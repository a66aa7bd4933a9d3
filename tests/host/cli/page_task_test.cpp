#include "host/cli/view/page_task.h"

#include <latch>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/viewer/panel_messages.h"

namespace stof::host {
namespace {

using namespace std::chrono_literals;
using viewer::PairingState;
using Task = PageTask<PairingState>;

constexpr std::chrono::milliseconds kLong = 60s;  // for what has to come

class PageTaskTest : public testing::Test {
 protected:
  viewer::Page page(std::uint64_t number, const std::string& place) const {
    return {.number = number, .place = place, .there = there_};
  }
  // Begins one that ends with the digits that its page gives, or when it is ended.
  Task::Done begin(const viewer::Page& by) {
    return task_.start(
        by, "busy", [](PairingState& state) { state.step = "digits"; },
        [this]() -> Task::End {
          const bool given =
              task_.await(kLong, [](const PairingState& state) { return !state.given.empty(); });
          return {.step = given ? "paired" : "failed", .text = task_.state().given};
        });
  }
  Task::Done give(const viewer::Page& by, const std::string& digits) {
    return task_.change_by(by, [&](PairingState& state) -> Task::Done {
      state.given = digits;
      return {};
    });
  }
  // Waits until what is under way has ended.
  void until_over() {
    while (task_.under_way()) {
      std::this_thread::sleep_for(1ms);
    }
  }

  const std::shared_ptr<int> there_ = std::make_shared<int>();
  const viewer::Page own_ = page(1, "this computer");
  const viewer::Page stranger_ = page(2, "192.0.2.7");
  std::vector<PairingState> told_;  // under the task's lock
  Task task_{{}, [this](const PairingState& state) { told_.push_back(state); }};
};

TEST_F(PageTaskTest, BelongsToThePageThatBeganIt) {
  ASSERT_TRUE(begin(stranger_));
  EXPECT_EQ(task_.state().by.page, 2U);
  EXPECT_EQ(task_.state().by.place, "192.0.2.7");
  const Task::Done given = give(own_, "123456");
  ASSERT_FALSE(given);
  EXPECT_EQ(given.error(),
            "another page, of 192.0.2.7, began this: only that page goes on with it or ends it");
  EXPECT_EQ(task_.end_by(own_, "none").error(), given.error());
  EXPECT_EQ(begin(own_).error(), "busy");
  EXPECT_TRUE(task_.goes_on());
  EXPECT_EQ(task_.state().given, "");
  EXPECT_EQ(task_.state().by.page, 2U);
  ASSERT_TRUE(give(stranger_, "654321"));
  until_over();
  EXPECT_EQ(task_.state().step, "paired");
  EXPECT_EQ(task_.state().text, "654321");
}

TEST_F(PageTaskTest, ItsPageEndsItAndTheNextIsAnothers) {
  EXPECT_EQ(task_.end_by(own_, "none").error(), "none");
  ASSERT_TRUE(begin(own_));
  ASSERT_TRUE(task_.end_by(own_, "none"));
  until_over();
  EXPECT_EQ(task_.state().step, "failed");
  EXPECT_EQ(task_.end_by(own_, "none").error(), "none");
  ASSERT_TRUE(begin(stranger_));
  EXPECT_FALSE(give(own_, "1"));
  EXPECT_TRUE(task_.end_by(stranger_, "none"));
}

TEST_F(PageTaskTest, TellsEachStateInItsOrder) {
  ASSERT_TRUE(begin(own_));
  ASSERT_TRUE(give(own_, "1"));
  EXPECT_FALSE(task_.change_by(
      own_, [](PairingState&) -> Task::Done { return std::unexpected("why not"); }));
  until_over();
  std::vector<std::string> steps;
  task_.change([&](PairingState&) {
    for (const PairingState& one : told_) {
      steps.push_back(one.step + " " + one.given);
    }
  });
  EXPECT_EQ(steps, (std::vector<std::string>{"digits ", "digits 1", "paired 1"}));
}

TEST_F(PageTaskTest, WorkThatThrowsHasFailedWithItsLine) {
  ASSERT_TRUE(task_.start(
      own_, "busy", [](PairingState&) {},
      []() -> Task::End { throw std::runtime_error("no answer"); }));
  until_over();
  EXPECT_EQ(task_.state().step, "failed");
  EXPECT_EQ(task_.state().text, "no answer");
}

TEST_F(PageTaskTest, EndsWithTheProgram) {
  std::latch begun(1);
  std::string text;
  {
    Task task({}, [&](const PairingState& state) { text = state.text; });
    ASSERT_TRUE(task.start(
        own_, "busy", [](PairingState&) {},
        [&]() -> Task::End {
          begun.count_down();
          const bool is = task.await(kLong, [](const PairingState&) { return false; });
          return {.step = "failed", .text = is || task.goes_on() ? "goes on" : "ended"};
        }));
    begun.wait();
  }
  EXPECT_EQ(text, "ended");
}

}  // namespace
}  // namespace stof::host
