#include "host/cli/recording/recorded_link.h"

#include <chrono>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace stof::host {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kMs = 1'000'000;
constexpr std::uint64_t kBegin = 1'700'000'000'000 * kMs;

// "2.420 link: ...": when, in seconds from the begin, and what.
std::vector<std::string> lines(const RecordedLink& link) {
  std::vector<std::string> all;
  for (const RecordedLink::Change& change : link.changes()) {
    const std::uint64_t ms = (change.log_time - kBegin) / kMs;
    all.push_back(std::to_string(ms) + " " + change.change.text);
  }
  return all;
}

// Frames each 100 ms from one time until before another one, ms.
void frames(RecordedLink& link, int from, int until) {
  for (int at = from; at < until; at += 100) {
    link.frame(kBegin + static_cast<std::uint64_t>(at) * kMs, 100ms, false);
  }
}

TEST(RecordedLink, TellsASilenceAndItsEndWhenTheyWereSeen) {
  RecordedLink link;
  frames(link, 0, 3000);
  EXPECT_TRUE(link.changes().empty());
  frames(link, 6000, 9000);
  EXPECT_EQ(lines(link), (std::vector<std::string>{
                             "3220 link: the sensor is silent, its last frame is 0.3 s old",
                             "7000 link: the sensor sends again"}));
  EXPECT_EQ(link.silences(), 1U);
  EXPECT_TRUE(link.changes()[0].change.active);
  EXPECT_FALSE(link.changes()[1].change.active);
}

TEST(RecordedLink, TellsAStartBehindASilence) {
  RecordedLink link;
  frames(link, 0, 1000);
  link.frame(kBegin + 3000 * kMs, 100ms, true);
  frames(link, 3100, 5000);
  EXPECT_EQ(lines(link),
            (std::vector<std::string>{
                "1220 link: the sensor is silent, its last frame is 0.3 s old",
                "3000 link: the sensor started again", "4000 link: the sensor sends again"}));
}

TEST(RecordedLink, AFrameThatIsMissingIsNoSilence) {
  RecordedLink link;
  frames(link, 0, 1000);
  frames(link, 1200, 2000);  // two periods and one more
  EXPECT_TRUE(link.changes().empty());
}

TEST(RecordedLink, BelievesNoPeriodThatFramesDoNotBear) {
  RecordedLink link;
  for (int at = 0; at < 1000; at += 100) {
    link.frame(kBegin + static_cast<std::uint64_t>(at) * kMs, 1h, false);
  }
  link.frame(kBegin + 4000 * kMs, 1h, false);
  EXPECT_EQ(link.changes().size(), 1U);
}

TEST(RecordedLink, TakesAnyTime) {
  RecordedLink link;
  link.frame(0, 0ns, false);
  link.frame(std::numeric_limits<std::uint64_t>::max(), -1ns, false);
  link.frame(5, std::chrono::nanoseconds::max(), true);
  EXPECT_EQ(link.changes().size(), 2U);
}

}  // namespace
}  // namespace stof::host
