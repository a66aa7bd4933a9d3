#include <gtest/gtest.h>

#include "board/board.h"

// The table of a board with real devices.
namespace stof::board {
namespace {

TEST(BoardConfig, FramesAreStampedByWhatIsMoreUrgent) { EXPECT_LT(kConfig.devices.priority, 50); }

TEST(BoardConfig, WhatDoesNotFitIsNoBoard) {
  Config config = kConfig;
  EXPECT_TRUE(valid(config));
  config.devices.v4l2.most_delay = config.timing.period;
  EXPECT_FALSE(valid(config)) << "stamps of two edges mix";
  config = kConfig;
  config.devices.watchdog_timeout = 2 * config.timing.period;
  EXPECT_FALSE(valid(config));
  config = kConfig;
  config.devices.pmd.edge_tolerance = config.timing.period / 2;
  EXPECT_FALSE(valid(config));
}

}  // namespace
}  // namespace stof::board
