#include "host/cli/live/frame_wait.h"

#include <chrono>

#include <gtest/gtest.h>

#include "firmware/wire/messages/conditions.h"

namespace stof::host {
namespace {

using namespace std::chrono_literals;

client::LinkState silent(std::optional<client::Duration> frame_age,
                         std::optional<client::Duration> health_age) {
  return {.silent = true, .frame_age = frame_age, .health_age = health_age};
}

TEST(FrameWait, TellsWhatComesBesideFrames) {
  EXPECT_EQ(what_comes({.silent = false, .frame_age = 10ms, .health_age = 900ms}), Comes::kFrames);
  EXPECT_EQ(what_comes(silent({}, {})), Comes::kNothing);
  EXPECT_EQ(what_comes(silent({}, 300ms)), Comes::kHealthAlone);
  EXPECT_EQ(what_comes(silent(5s, 300ms)), Comes::kHealthAlone);
  EXPECT_EQ(what_comes(silent(500ms, 900ms)), Comes::kNothing) << "none since the last frame";
  EXPECT_EQ(what_comes(silent(5s, 4s)), Comes::kNothing) << "two are overdue";
}

TEST(FrameWait, SaysWhatHealthSays) {
  wire::HealthReport health{.severity = wire::Severity::kCritical};
  health.active = 1U << static_cast<unsigned>(wire::Condition::kTriggerLost);
  const std::string text = health_alone_text(silent(5s, 300ms), health);
  EXPECT_EQ(text,
            ": its health comes, and no frame: no data, active: trigger_lost; "
            "stof health says what each means");
  EXPECT_EQ(health_alone_text(silent(5s, 4s), health), "");
  EXPECT_EQ(health_alone_text(silent(5s, 300ms), std::nullopt), "");
}

}  // namespace
}  // namespace stof::host
