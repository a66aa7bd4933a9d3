#include "dsp/fusion/resolve/match_evidence.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "tests/dsp/fusion/resolve/evidence_scene.h"

namespace stof::dsp {
namespace {

using test::kHeight;
using test::kRange;
using test::kWidth;
using test::rig;
using Scene = test::EvidenceScene;
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

TEST(MatchEvidence, AnIndistinctMatchWhereThePictureChangesIsDoubtful) {
  Scene plain;
  EXPECT_EQ(plain.judge(250).verdict, kKept);
  Scene scene;
  scene.brighten(32, 50);
  EXPECT_EQ(scene.judge(100).verdict, kKept);
  EXPECT_EQ(scene.judge(250).verdict, kDoubtful);
  scene.read(12100, 20);
  EXPECT_EQ(scene.judge(250).verdict, kConfirmed);
  Scene wide(70);  // what such a PMD camera does not see says little
  wide.brighten(32, 50);
  EXPECT_EQ(wide.judge(250).verdict, kKept);
}

TEST(MatchEvidence, PixelsWithoutAMatchBesideItMakeItDoubtful) {
  Scene scene;
  EXPECT_EQ(scene.judge(255).verdict, kKept);
  for (int y = 20; y <= 28; ++y) {
    for (int x = 24; x < 32; ++x) {
      scene.view().at(x, y) = Disparity::none();
    }
  }
  EXPECT_EQ(scene.judge(255).verdict, kDoubtful);
}

TEST(MatchEvidence, AnEdgeOfThePictureSpeaksForAMatchBeforeItAndAgainstOneBehindIt) {
  struct Case {
    int edge;
    std::uint8_t ratio;
    MatchEvidence::Verdict verdict;
  };
  for (const Case& one : {Case{36, 150, kKept}, Case{30, 12, kDoubtful}}) {
    Scene scene;
    for (int y = 0; y < kHeight; ++y) {  // the surface ends at column 36
      std::ranges::fill(scene.view().row(y).subspan(36), Disparity::from_pixels(15));
    }
    scene.brighten(one.edge, 80);
    EXPECT_EQ(scene.judge(one.ratio).verdict, one.verdict) << one.edge;
  }
}

TEST(Contrast, IsThatAlongTheRowOrAcrossIt) {
  std::vector<std::uint8_t> pixels(11 * 9, 50);
  const ImageView<std::uint8_t> picture(pixels.data(), 11, 9);
  EXPECT_EQ(contrast(picture, 4, 4), 0);
  std::ranges::fill(picture.row(2), std::uint8_t{90});  // a level bar
  EXPECT_EQ(contrast(picture, 4, 4), 80);
  EXPECT_EQ(contrast(picture, 0, 0), 80);
  EXPECT_EQ(contrast(picture, 4, 8), 0);
  picture.at(9, 4) = 150;  // beside the last pixel that is asked
  EXPECT_EQ(contrast(picture, 4, 4), 80);
  picture.at(8, 4) = 150;
  EXPECT_EQ(contrast(picture, 4, 4), 100);
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

TEST(MatchEvidence, AFoldedReadingOfAWidePixelAtAnEdgeContradictsButConfirmsNothing) {
  Scene scene(70);
  scene.read(12100, 20);
  EXPECT_EQ(scene.judge().verdict, kConfirmed);
  for (int y = 0; y < scene.maps.flags.height(); ++y) {
    std::ranges::fill(scene.maps.flags.row(y), std::uint8_t{kPmdWrapped | kPmdEdge});
  }
  scene.read(12100, 20);
  EXPECT_EQ(scene.judge().verdict, kKept);
  EXPECT_EQ(scene.evidence.judge_surface(32, 24, 12000).verdict, kAllowed);
  scene.read(9000, 20);
  EXPECT_EQ(scene.judge(0).verdict, kContradicted);
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
  EXPECT_EQ(evidence.judge(match, {scene.view(), scene.picture()}).verdict, kKept);
  scene.unmatched();
  EXPECT_EQ(evidence.judge(match, {scene.view(), scene.picture()}).verdict, kUnsupported);
}

TEST(MatchEvidence, ASurfaceIsConfirmedByAFoldedReadingOfIt) {
  Scene scene;
  scene.read(35000 - kRange, 20);
  const MatchEvidence::Result result = scene.evidence.judge_surface(32, 24, 34000);
  EXPECT_EQ(result.verdict, kConfirmed);                   // a twentieth of the distance
  EXPECT_NEAR(result.reading.low, 35000 - 40 - 1020, 40);  // 2 sigma and 3 percent
  EXPECT_NEAR(result.reading.high, 35000 + 40 + 1020, 40);
  EXPECT_EQ(scene.evidence.judge_surface(32, 24, 31000).verdict, kContradicted);
}

TEST(MatchEvidence, AWidePixelConfirmsNoSurface) {
  Scene scene(70);
  scene.read(12100, 20);
  EXPECT_EQ(scene.evidence.judge_surface(32, 24, 12000).verdict, kAllowed);
  scene.read(9000, 20);
  EXPECT_EQ(scene.evidence.judge_surface(32, 24, 12000).verdict, kContradicted);
}

TEST(MatchEvidence, ASurfaceIsAllowedOrContradictedByWhatThePmdSees) {
  Scene scene;
  EXPECT_EQ(scene.evidence.judge_surface(32, 24, 12000).verdict, kKept);
  scene.see(11000, 13000);
  EXPECT_EQ(scene.evidence.judge_surface(32, 24, 12000).verdict, kAllowed);
  scene.see(14000, 15000);
  EXPECT_EQ(scene.evidence.judge_surface(32, 24, 12000).verdict, kContradicted);
  scene.see(8000, 9000);
  EXPECT_EQ(scene.evidence.judge_surface(32, 24, 12000).verdict, kContradicted);
}

TEST(MatchEvidence, AWidePixelBesideMayBeTheOneThatSeesASurface) {
  for (const bool wide : {false, true}) {
    Scene scene(wide ? 70 : 150);
    scene.see(14000, 15000);
    const PmdView::Place place = PmdView(rig(wide ? 70 : 150)).of(32, 24, 12000);
    scene.maps.low.at(place.column + 1, place.row) = 11000;
    EXPECT_EQ(scene.evidence.judge_surface(32, 24, 12000).verdict, wide ? kAllowed : kContradicted);
  }
}

}  // namespace
}  // namespace stof::dsp
