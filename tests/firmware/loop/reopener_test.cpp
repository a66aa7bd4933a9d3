#include "firmware/loop/reopener.h"

#include <gtest/gtest.h>

#include "tests/firmware/rig.h"

namespace stof::board {

namespace {
int asked = 0;
}  // namespace

// Of a board whose device stays away.
Status reopen(Board&) noexcept {
  ++asked;
  return Status::kDeviceLost;
}

}  // namespace stof::board

namespace stof::firmware::test {
namespace {

TEST(Reopener, AsksSoonAtFirstThenFourTimesASecondAndNeverWithoutNeed) {
  Rig rig;
  Reopener reopener(rig.board);
  board::asked = 0;
  reopener.after(Status::kOk);
  EXPECT_EQ(board::asked, 0);
  const hal::Time lost = rig.clock.now();
  std::vector<hal::Duration> when;
  while (rig.clock.now() - lost < 10s) {
    const int before = board::asked;
    reopener.after(Status::kDeviceLost);
    if (board::asked != before) {
      when.push_back(rig.clock.now() - lost);
    }
    rig.clock.wait_until(rig.clock.now() + 1ms);
  }
  ASSERT_GE(when.size(), 4U);
  EXPECT_EQ(when[0], 0ms);
  EXPECT_EQ(when[1], 50ms);
  EXPECT_EQ(when[2], 150ms);
  for (std::size_t i = 4; i < when.size(); ++i) {
    EXPECT_EQ(when[i] - when[i - 1], 250ms);
  }
  // Back, and lost again: at once.
  reopener.after(Status::kOk);
  const int before = board::asked;
  rig.clock.wait_until(rig.clock.now() + 250ms);
  reopener.after(Status::kDeviceLost);
  EXPECT_EQ(board::asked, before + 1);
}

}  // namespace
}  // namespace stof::firmware::test
