#include "host/bridge/line_limit.h"

#include <gtest/gtest.h>

namespace stof::bridge {
namespace {

using std::chrono::milliseconds;

TEST(LineLimit, AFloodIsTenLinesAMinuteAndTheirNumber) {
  LineLimit limit;
  LineLimit::Clock::time_point now{};
  int written = 0;
  std::optional<std::string> newest;
  for (int k = 0; k < 60'000; ++k) {  // in five minutes
    if (auto text = limit.pass("malformed packet\n", now)) {
      newest = std::move(text);
      ++written;
      EXPECT_EQ(newest->contains("left out"), written % LineLimit::kLines == 1 && k > 0) << k;
    }
    now += milliseconds(5);
  }
  EXPECT_EQ(written, 5 * LineLimit::kLines);
  EXPECT_EQ(limit.pass("the end", now + LineLimit::kWindow),
            "the end (11990 lines before this one are left out)");
}

TEST(LineLimit, ALineNowAndThenIsWhatWasSaid) {
  LineLimit limit;
  LineLimit::Clock::time_point now{};
  for (int k = 0; k < 100; ++k) {
    EXPECT_EQ(limit.pass("no route\r\n", now), "no route");
    now += milliseconds(6001);
  }
}

TEST(LineLimit, ControlsNoTerminal) {
  LineLimit limit;
  EXPECT_EQ(limit.pass("a\033[2Jb", {}), "a?[2Jb");
  EXPECT_EQ(limit.pass("\n", {}), "");
}

}  // namespace
}  // namespace stof::bridge
