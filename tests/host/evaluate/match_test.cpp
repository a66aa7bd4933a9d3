#include "host/evaluate/stereo/match.h"

#include <utility>

#include <gtest/gtest.h>

#include "tests/host/evaluate/fusion_scene.h"

namespace stof::host {
namespace {

MatchRequest with(std::vector<std::pair<std::string, std::string>> settings) {
  MatchRequest options;
  options.settings = std::move(settings);
  return options;
}

TEST(MatchRequest, BecomeAnIntegerDenseSearchByDefault) {
  const std::expected<MatchPlan, dataset::Problem> plan = match_plan({}, 48);
  ASSERT_TRUE(plan) << plan.error().message;
  EXPECT_EQ(plan->params.min_disparity, 0);
  EXPECT_EQ(plan->params.disparities, 48);
  EXPECT_EQ(plan->params.block_width, 16);
  EXPECT_EQ(plan->params.block_height, 16);
  EXPECT_EQ(plan->params.prefilter_cap, lab::MatchParams{}.prefilter_cap);
  EXPECT_FALSE(plan->params.left_right_tolerance.has_value());
  EXPECT_EQ(plan->params.subpixel, dsp::Subpixel::kWhole);
  EXPECT_FALSE(plan->annealing);
}

TEST(MatchRequest, AddWhatWasAskedFor) {
  const auto plan =
      match_plan(with({{"block", "60x20"}, {"lr", "1"}, {"subpixel", "equiangular"}}), 16);
  ASSERT_TRUE(plan) << plan.error().message;
  EXPECT_EQ(plan->params.block_width, 60);
  EXPECT_EQ(plan->params.block_height, 20);
  EXPECT_EQ(plan->params.left_right_tolerance, 1);
  EXPECT_EQ(plan->params.subpixel, dsp::Subpixel::kEquiangular);
}

TEST(MatchRequest, ChangeAPreset) {
  MatchRequest options = with({{"fill", "on"}, {"speckle", "off"}});
  options.preset = "quality";
  const auto plan = match_plan(options, 64);
  ASSERT_TRUE(plan) << plan.error().message;
  EXPECT_EQ(plan->params.method, lab::Method::kSemiGlobal);
  EXPECT_TRUE(plan->params.fill);
  EXPECT_FALSE(plan->params.speckle_pixels);
}

TEST(MatchRequest, RefuseEveryImpossibleBlock) {
  for (const char* block : {"", "x", "16", "16x", "x16", "0x16", "16x0", "65x16", "16x65", "-1x16",
                            "16x16x16", "16 x16", "16X16", "1e1x16", "99999999999x16", "+1x1"}) {
    const auto plan = match_plan(with({{"block", block}}), 16);
    ASSERT_FALSE(plan) << block;
    EXPECT_EQ(plan.error().message, std::string("--block ") + block +
                                        ": not one of its values: use WxH from 1x1 to 64x64");
  }
}

TEST(MatchRequest, RefuseWhatIsUnknownOrDoesNotGoTogether) {
  EXPECT_FALSE(match_plan(with({{"method", "bm"}}), 16));
  EXPECT_FALSE(match_plan(with({{"shape", "region"}, {"method", "sgm"}}), 16));
  EXPECT_FALSE(match_plan(with({{"interest", "maxima"}, {"prefilter", "off"}}), 16));
  MatchRequest options;
  options.preset = "best";
  EXPECT_FALSE(match_plan(options, 16));
}

TEST(MatchRequest, TakeOneThreadUnlessTheySayMore) {
  EXPECT_EQ(match_plan({}, 16)->threads, 1);
  for (const int threads : {-1, 0, 9}) {
    MatchRequest options;
    options.threads = threads;
    const auto plan = match_plan(options, 16);
    ASSERT_FALSE(plan);
    EXPECT_EQ(plan.error().message, "--threads " + std::to_string(threads) + ": use 1 to 8");
  }
}

TEST(MatchScene, IsTheSameForAnyNumberOfThreads) {
  const dataset::StereoScene scene = test::shifted_scene();
  for (const char* const name : {"fast", "quality", "chapter"}) {
    MatchRequest options = with({{"fill", "on"}});
    options.preset = name;
    const MatchResult alone = *match_scene(scene, *match_plan(options, scene.ndisp));
    for (options.threads = 2; options.threads <= dsp::ThreadTeam::kMost; ++options.threads) {
      const MatchResult result = *match_scene(scene, *match_plan(options, scene.ndisp));
      EXPECT_EQ(result.disparity.pixels, alone.disparity.pixels) << name << options.threads;
      EXPECT_EQ(result.filled.pixels, alone.filled.pixels) << name << options.threads;
    }
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
