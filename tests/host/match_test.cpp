#include "host/evaluate/match.h"

#include <gtest/gtest.h>

namespace stof::host {
namespace {

TEST(MatchOptions, BecomeAnIntegerDenseSearchByDefault) {
  const std::expected<dsp::MatchParams, dataset::Problem> params = match_params({}, 48);
  ASSERT_TRUE(params) << params.error().message;
  EXPECT_EQ(params->min_disparity, 0);
  EXPECT_EQ(params->disparities, 48);
  EXPECT_EQ(params->block_width, 16);
  EXPECT_EQ(params->block_height, 16);
  EXPECT_EQ(params->prefilter_cap, dsp::MatchParams{}.prefilter_cap);
  EXPECT_FALSE(params->left_right_tolerance.has_value());
  EXPECT_EQ(params->subpixel, dsp::Subpixel::kWhole);
}

TEST(MatchOptions, AddWhatWasAskedFor) {
  MatchOptions options;
  options.block = "60x20";
  options.left_right = true;
  options.subpixel = true;
  const std::expected<dsp::MatchParams, dataset::Problem> params = match_params(options, 16);
  ASSERT_TRUE(params) << params.error().message;
  EXPECT_EQ(params->block_width, 60);
  EXPECT_EQ(params->block_height, 20);
  EXPECT_EQ(params->left_right_tolerance, 1);
  EXPECT_EQ(params->subpixel, dsp::Subpixel::kEquiangular);
}

TEST(MatchOptions, RefuseEveryImpossibleBlock) {
  for (const char* block : {"", "x", "16", "16x", "x16", "0x16", "16x0", "65x16", "16x65", "-1x16",
                            "16x16x16", "16 x16", "16X16", "1e1x16", "99999999999x16", "+1x1"}) {
    MatchOptions options;
    options.block = block;
    const std::expected<dsp::MatchParams, dataset::Problem> params = match_params(options, 16);
    ASSERT_FALSE(params) << block;
    EXPECT_EQ(params.error().message,
              std::string("--block ") + block + ": not a block size: use WxH from 1x1 to 64x64");
  }
}

TEST(Workspace, GivesAlignedMemoryOfAtLeastTheSize) {
  Workspace workspace(1000);
  dsp::Arena arena = workspace.arena();
  EXPECT_EQ(arena.take<std::byte>(1000).size(), 1000U);  // checks its alignment itself
}

TEST(MedianTime, RunsTheWorkAsOftenAsAsked) {
  int runs = 0;
  EXPECT_GE(median_time_ms(3, [&runs] { ++runs; }), 0);
  EXPECT_EQ(runs, 3);
}

}  // namespace
}  // namespace stof::host
