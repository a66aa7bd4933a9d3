#include "dsp/fusion/resolve/match_evidence.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace stof::dsp {
namespace {

// f b = 60 px m. The PMD camera sees the same picture, four pixels in one, from the same place.
constexpr int kWidth = 64;
constexpr int kHeight = 48;
constexpr int kFour = 4;
constexpr std::uint32_t kRange = 29979;

Calibration rig(double focal = 150) {
  Calibration calibration;
  calibration.stereo = {
      .left = {.width = kWidth, .height = kHeight, .fx = 600, .fy = 600, .cx = 31.5, .cy = 23.5},
      .baseline_m = 0.1};
  calibration.pmd.lens = {.width = kWidth / kFour,
                          .height = kHeight / kFour,
                          .fx = focal,
                          .fy = focal,
                          .cx = 7.5,
                          .cy = 5.5};
  return calibration;
}

// A wall matched at 20 px, 3 m away, and a PMD picture without any reading.
class Scene {
 public:
  explicit Scene(double focal = 150)
      : evidence(rig(focal), 0),
        disparity_(kWidth * kHeight, Disparity::from_pixels(20)),
        images_(4, std::vector<QuarterMm>(kWidth * kHeight / kFour / kFour)),
        flags_(kWidth * kHeight / kFour / kFour) {
    maps.low = image(0);
    maps.high = image(1);
    maps.folded = image(2);
    maps.folded_sigma = image(3);
    maps.flags = {flags_.data(), kWidth / kFour, kHeight / kFour};
    maps.range = kRange;
    evidence.look_at(&maps);
  }

  ImageView<Disparity> view() { return {disparity_.data(), kWidth, kHeight}; }
  void unmatched() { std::ranges::fill(disparity_, Disparity::none()); }
  void read(QuarterMm folded, QuarterMm sigma) {
    std::ranges::fill(images_[2], folded);
    std::ranges::fill(images_[3], sigma);
  }
  void see(QuarterMm low, QuarterMm high) {
    std::ranges::fill(images_[0], low);
    std::ranges::fill(images_[1], high);
  }
  MatchEvidence::Result judge(std::uint8_t ratio = 200, int x = 32, int y = 24,
                              DepthInterval interval = {11800, 12200}) {
    return evidence.judge({.x = x,
                           .y = y,
                           .disparity = Disparity::from_pixels(20),
                           .ratio = ratio,
                           .interval = interval},
                          view());
  }

  MatchEvidence evidence;
  PmdMaps maps;

 private:
  ImageView<QuarterMm> image(std::size_t k) {
    return {images_[k].data(), kWidth / kFour, kHeight / kFour};
  }
  std::vector<Disparity> disparity_;
  std::vector<std::vector<QuarterMm>> images_;
  std::vector<std::uint8_t> flags_;
};

using enum MatchEvidence::Verdict;

TEST(MatchEvidence, NothingIsJudgedWithoutAPmdFrame) {
  MatchEvidence evidence(rig(), 0);
  EXPECT_FALSE(evidence.judges());
  const PmdMaps maps;
  evidence.look_at(&maps);
  EXPECT_TRUE(evidence.judges());
}

TEST(MatchEvidence, MatchesAroundItSupportAMatch) {
  Scene scene;
  EXPECT_EQ(scene.judge().verdict, kKept);
  scene.unmatched();
  EXPECT_EQ(scene.judge().verdict, kUnsupported);
  for (int y = 24; y < 32; y += 4) {  // 7 of 16: enough for a sure match alone
    for (int x = 24; x <= 40; ++x) {
      scene.view().at(x, y) = Disparity::from_raw(20 * 16 + 13);
    }
  }
  EXPECT_EQ(scene.judge(200).verdict, kUnsupported);
  EXPECT_EQ(scene.judge(100).verdict, kKept);
  for (Disparity& d : std::span(scene.view().row(0).data(), kWidth * kHeight)) {
    d = d.valid() ? Disparity::from_raw(20 * 16 + 14) : d;  // more than a 24th of the parallax
  }
  EXPECT_EQ(scene.judge(100).verdict, kUnsupported);
}

TEST(MatchEvidence, AFoldedReadingOfTheSameSurfaceConfirms) {
  Scene scene;
  scene.read(12100, 20);
  const MatchEvidence::Result result = scene.judge();
  EXPECT_EQ(result.verdict, kConfirmed);
  EXPECT_NEAR(result.reading.low, 12100 - 40 - 120, 3);  // 2 sigma and a percent
  EXPECT_NEAR(result.reading.high, 12100 + 40 + 120, 3);
}

TEST(MatchEvidence, AFoldedReadingConfirmsWholeRangesAway) {
  Scene scene;
  scene.read(35000 - kRange, 20);
  std::ranges::fill(std::span(scene.view().row(0).data(), kWidth * kHeight),
                    Disparity::from_pixels(20));
  EXPECT_EQ(scene.judge(200, 32, 24, {34000, 36000}).verdict, kConfirmed);
  EXPECT_EQ(scene.judge(200, 32, 24, {31000, 32000}).verdict, kContradicted);
}

TEST(MatchEvidence, AFoldedReadingOfAnotherSurfaceContradicts) {
  Scene scene;
  scene.read(9000, 20);
  EXPECT_EQ(scene.judge(0).verdict, kContradicted);
  scene.read(9000, 1600);  // so noisy that it may be the same
  EXPECT_NE(scene.judge(0).verdict, kContradicted);
}

TEST(MatchEvidence, AReadingThatWouldAgreeByChanceSaysNothing) {
  Scene scene;
  scene.maps.range = 10'000;  // 60 MHz
  scene.read(2100, 20);
  EXPECT_EQ(scene.judge().verdict, kConfirmed);
  scene.read(2100, 600);  // 2 sigma to either side are a quarter of the range
  EXPECT_EQ(scene.judge().verdict, kKept);
  scene.read(7000, 600);
  EXPECT_EQ(scene.judge().verdict, kKept);
}

TEST(MatchEvidence, WhatThePmdSeesBeyondSixteenMetresIsNoMatchBeforeIt) {
  Scene scene;
  scene.maps.flags.at(8, 6) = kPmdOutOfRange;
  EXPECT_EQ(scene.judge().verdict, kContradicted);
  scene.maps.flags.at(8, 6) = kPmdOutOfRange | kPmdLowAmplitude;
  EXPECT_EQ(scene.judge().verdict, kKept);
}

TEST(MatchEvidence, AtTheBorderAsManyAreAskedAsThereAre) {
  Scene scene;
  for (const auto& [x, y] : {std::pair{0, 0}, {63, 47}, {0, 24}, {5, 47}}) {
    EXPECT_EQ(scene.judge(200, x, y).verdict, kKept) << x << "," << y;
  }
}

TEST(MatchEvidence, WhatLiesBeforeTheMatchMayHideItAndWhatLiesBehindContradicts) {
  Scene scene;
  scene.see(8000, 9000);
  EXPECT_EQ(scene.judge().verdict, kKept);
  scene.see(14000, 15000);
  EXPECT_EQ(scene.judge(0).verdict, kContradicted);
}

TEST(MatchEvidence, APixelBesideAWideOneMayBeTheOneThatSeesIt) {
  for (const bool wide : {false, true}) {
    // Wide pixels: a shorter lens sees less of the picture in more of its pixels' width.
    Scene scene(wide ? 70 : 150);
    scene.see(14000, 15000);
    const PmdView::Place place = PmdView(rig(wide ? 70 : 150)).of(32, 24, 12000);
    ASSERT_TRUE(place.seen());
    scene.maps.low.at(place.column + 1, place.row) = 11000;
    EXPECT_EQ(scene.judge(0).verdict, wide ? kKept : kContradicted);
  }
}

TEST(MatchEvidence, OutsideOfThePmdPictureLessIsAsked) {
  Scene scene;
  scene.see(14000, 15000);
  const DepthInterval near{1000, 1010};
  EXPECT_EQ(scene.judge(200, 2, 2).verdict, kContradicted);
  Calibration aside = rig();
  aside.pmd_to_stereo.translation_m = {2, 0, 0};  // sees none of it
  MatchEvidence evidence(aside, 0);
  evidence.look_at(&scene.maps);
  const MatchEvidence::Match match{
      .x = 32, .y = 24, .disparity = Disparity::from_pixels(20), .ratio = 200, .interval = near};
  EXPECT_EQ(evidence.judge(match, scene.view()).verdict, kKept);
  scene.unmatched();
  EXPECT_EQ(evidence.judge(match, scene.view()).verdict, kUnsupported);
}

}  // namespace
}  // namespace stof::dsp
