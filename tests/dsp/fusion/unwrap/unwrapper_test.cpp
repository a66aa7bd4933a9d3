#include "dsp/fusion/unwrap/unwrapper.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/dsp/fusion/unwrap/unwrap_rig.h"

namespace stof::dsp {
namespace {

constexpr double kRange = kTurn / 4000.0;  // metres
constexpr int kDim = 20;                   // 2 A: of no use where white_lsb is 2000

using Surface = UnwrapRig::Surface;
const Surface kNothing = [](double, double) { return 0.0; };

Surface sphere(double metres) {
  return [metres](double, double) { return metres; };
}

Calibration rig_with_white(double white_lsb, int width = 24, int height = 18) {
  Calibration rig = unwrap_calibration(width, height);
  rig.pmd.white_lsb = white_lsb;
  return rig;
}

TEST(Unwrap, IsNeededWhereTheRangeIsLongerThanATurn) {
  const Calibration rig = unwrap_calibration(4, 4);
  EXPECT_TRUE(Unwrapper::needed(rig.pmd, {.max_range = kTurn + 1}));
  EXPECT_FALSE(Unwrapper::needed(rig.pmd, {.max_range = kTurn}));
  PmdSensor stretched = rig.pmd;
  stretched.scale = 1.01;
  EXPECT_FALSE(Unwrapper::needed(stretched, {.max_range = kTurn + 1}));
  EXPECT_FALSE(Unwrapper::needed(PmdSensor{}, {}));
}

TEST(Unwrap, TakesTheWrapCountThatStereoSupports) {
  for (const double metres : {2.0, 3.0, 7.0, 8.2, 3.0 + kRange, 14.0, 15.5}) {
    UnwrapRig rig(rig_with_white(2000));
    rig.measure(sphere(metres), kDim);
    rig.match(sphere(metres));
    rig.resolve();
    EXPECT_EQ(rig.share_right(sphere(metres)), 1.0) << metres << " m";
    EXPECT_EQ(rig.pmd.maps.sigma.at(5, 5), 40);
    EXPECT_GT(rig.pmd.maps.low.at(5, 5), rig.at(5, 5) - 100);
    EXPECT_LT(rig.pmd.maps.high.at(5, 5), rig.at(5, 5) + 100);
  }
}

TEST(Unwrap, ChangesNothingOfAFrameWhoseRangeIsLongEnough) {
  UnwrapRig rig(rig_with_white(2000), 20000);
  rig.measure(sphere(2.0), kDim);
  rig.match(sphere(2.0 + kRange));
  rig.resolve();
  EXPECT_EQ(rig.share_right(sphere(2.0)), 1.0);
  EXPECT_GT(rig.pmd.maps.low.at(5, 5), 0);
}

TEST(Unwrap, FlagsWhatNobodySpeaksFor) {
  UnwrapRig rig(rig_with_white(2000));
  rig.measure(sphere(3.0), kDim);
  rig.match(kNothing);
  rig.resolve();
  EXPECT_EQ(rig.share_flagged(), 1.0);
}

TEST(Unwrap, ProvesWhatIsTooBrightForMore) {
  // White at 10.49 m returns 2 * 2000 / 10.49^2 = 36; half as much again is 54.
  for (const bool bright : {false, true}) {
    UnwrapRig rig(rig_with_white(2000));
    rig.measure(sphere(3.0), bright ? 57 : 52, 4);
    rig.resolve_without_stereo();
    EXPECT_EQ(rig.share_right(sphere(3.0)), bright ? 1.0 : 0.0);
    EXPECT_EQ(rig.share_flagged(), bright ? 0.0 : 1.0);
  }
}

TEST(Unwrap, KnowsTheIntegrationTimeOfAnAmplitude) {
  UnwrapRig rig(rig_with_white(2000));
  rig.measure(sphere(3.0), 57, 4);
  rig.pmd.maps.integration = 2 * kReferenceIntegration;  // half as bright as it looks
  rig.resolve_without_stereo();
  EXPECT_EQ(rig.share_flagged(), 1.0);
}

TEST(Unwrap, DoesNotProveByAnAmplitudeThatIsNoise) {
  UnwrapRig rig(rig_with_white(2000));
  rig.measure(sphere(3.0), 60, 600);  // sigma of the amplitude: an eighth of it
  rig.resolve_without_stereo();
  EXPECT_EQ(rig.share_flagged(), 1.0);
}

TEST(Unwrap, FlagsAReadingThatIsBrightWhereStereoSeesAnother) {
  UnwrapRig rig(rig_with_white(2000));
  rig.measure(sphere(3.0), 200);
  rig.match(sphere(3.0 + kRange));
  rig.resolve();
  EXPECT_EQ(rig.share_flagged(), 1.0);
}

TEST(Unwrap, FlagsWhereStereoSpeaksForTwo) {
  UnwrapRig rig(rig_with_white(2000));
  rig.measure(sphere(3.0), kDim);
  rig.match([](double x, double) { return std::fmod(x + 10, 1.0) < 0.5 ? 3.0 : 3.0 + kRange; });
  rig.resolve();
  EXPECT_EQ(rig.share_flagged(), 1.0);
}

TEST(Unwrap, FlagsAReadingThatMayBeMixedFromFarApart) {
  UnwrapRig rig(rig_with_white(2000));
  rig.measure(sphere(3.0), 200);  // bright, so it has not wrapped
  const Surface step = [](double x, double) { return x < 12 ? 3.0 : 12.0; };
  rig.match(step);
  rig.resolve();
  EXPECT_EQ(rig.at(8, 9), 12000);
  EXPECT_TRUE(rig.flagged(12, 9));
}

TEST(Unwrap, AssumesNoWrapWhereNothingIsKnown) {
  UnwrapRig rig(rig_with_white(0));
  rig.measure(sphere(2.0), kDim);
  rig.match(kNothing);
  rig.resolve();
  EXPECT_EQ(rig.share_right(sphere(2.0)), 1.0);
}

// Without white_lsb: the left half is decided, by which the right half is too bright for 10.49 m,
// or not.
TEST(Unwrap, ComparesWithWhatStereoDecidedWhereWhiteIsUnknown) {
  for (const bool bright : {false, true}) {
    UnwrapRig rig(rig_with_white(0));
    rig.measure(sphere(3.0), 400);
    for (int y = 0; y < rig.height; ++y) {
      for (int x = 12; x < rig.width; ++x) {
        rig.pmd.maps.distance.at(x, y) = 11000;
        rig.pmd.maps.amp2.at(x, y) = bright ? 200 : 100;
      }
    }
    rig.match([](double x, double) { return x < 11.5 ? 3.0 : 0.0; });
    rig.resolve();
    EXPECT_EQ(rig.at(5, 9), 12000);
    EXPECT_EQ(rig.at(20, 9), bright ? 11000 : 0);
    EXPECT_EQ(rig.flagged(20, 9), !bright);
  }
}

TEST(Unwrap, FlagsWhatStereoSeesBeyondTheRange) {
  UnwrapRig rig(rig_with_white(2000), 40000);
  rig.measure(sphere(12.0), kDim);  // reads 4.5 m; 12 m is out of range
  rig.match(sphere(12.0));
  rig.resolve();
  EXPECT_EQ(rig.share_flagged(), 1.0);
  rig.measure(sphere(12.0), kDim);
  rig.resolve_without_stereo();  // nothing speaks against 4.5 m
  EXPECT_EQ(rig.share_right(sphere(12.0 - kRange)), 1.0);
}

TEST(Unwrap, CountsTheRangeAlongZ) {
  // 10.3 m along the rays in the corner is 9.9 m deep; in the middle it is out of range.
  UnwrapRig rig(rig_with_white(2000), 40000);
  rig.measure(sphere(10.3), kDim);
  rig.match(sphere(10.3));
  rig.resolve();
  EXPECT_TRUE(rig.flagged(12, 9));
  EXPECT_EQ(rig.at(0, 0), 41200);
}

TEST(Unwrap, FillsAHoleInASurface) {
  UnwrapRig rig(rig_with_white(2000));
  rig.measure(sphere(3.0 + kRange), kDim);
  rig.match([](double x, double y) {
    return std::abs(x - 12) < 2 && std::abs(y - 9) < 2 ? 0.0 : 3.0 + kRange;
  });
  rig.resolve();
  EXPECT_EQ(rig.share_right(sphere(3.0 + kRange)), 1.0);
}

// An untextured wall seems to go on in a thing before it, but it is darker.
TEST(Unwrap, DoesNotLeakFromOneSurfaceIntoAnother) {
  UnwrapRig rig(rig_with_white(2000));
  rig.measure(sphere(3.0), 80);
  for (int y = 0; y < rig.height; ++y) {
    for (int x = 12; x < rig.width; ++x) {
      rig.pmd.maps.amp2.at(x, y) = kDim;
    }
  }
  rig.match([](double x, double) { return x < 11.5 ? 3.0 : 0.0; });
  rig.resolve();
  EXPECT_EQ(rig.at(6, 9), 12000);
  for (int x = 14; x < rig.width; ++x) {
    EXPECT_TRUE(rig.flagged(x, 9)) << x;
  }
}

// A floor that begins bright and near and ends dark and far, of which stereo sees nothing: what its
// bright end proves holds for all of it.
TEST(Unwrap, CarriesAProofAlongASurface) {
  UnwrapRig rig(rig_with_white(2000));
  const Surface floor = [](double, double y) { return 3.0 + 0.01 * y; };
  rig.measure(floor, 100);
  for (int y = 0; y < rig.height; ++y) {
    for (int x = 0; x < rig.width; ++x) {
      rig.pmd.maps.amp2.at(x, y) = static_cast<std::uint16_t>(100 * std::pow(0.9, y));
    }
  }
  rig.resolve_without_stereo();
  EXPECT_LT(rig.pmd.maps.amp2.at(5, 17), 20);
  EXPECT_EQ(rig.share_right(floor), 1.0);
}

TEST(Unwrap, FollowsASurfaceAcrossTheWrap) {
  UnwrapRig rig(rig_with_white(2000));
  const Surface ramp = [](double x, double) { return 6.6 + 0.08 * x; };
  rig.measure(ramp, kDim);
  rig.match(ramp);
  rig.resolve();
  EXPECT_EQ(rig.share_right(ramp), 1.0);
}

// Without stereo in the far half: the proof crosses the wrap.
TEST(Unwrap, CarriesAProofAcrossTheWrap) {
  UnwrapRig rig(rig_with_white(200));
  const Surface ramp = [](double x, double) { return 7.15 + 0.03 * x; };
  rig.measure(ramp, kDim, 30);
  for (int y = 0; y < rig.height; ++y) {
    for (int x = 0; x < rig.width; ++x) {
      // 1.5 * 2 * 200 / 14.6^2 = 2.8: bright enough until it wraps. Behind, no more than white is.
      rig.pmd.maps.amp2.at(x, y) = static_cast<std::uint16_t>(2 * 200 / 50 - x / 8);
    }
  }
  rig.resolve_without_stereo();
  EXPECT_EQ(rig.share_right(ramp), 1.0);
}

TEST(Unwrap, KeepsEarlierFlagsAndMissingPixels) {
  UnwrapRig rig(rig_with_white(2000));
  rig.measure(kNothing, 0);
  rig.match(sphere(3.0));
  rig.resolve();
  EXPECT_EQ(rig.share_flagged(), 0.0);
  EXPECT_EQ(rig.pmd.maps.flags.at(3, 3), kPmdLowRatio);
  EXPECT_EQ(rig.at(3, 3), 0);
}

TEST(Unwrap, MarksAnEdgeBesideWhatIsUnknown) {
  UnwrapRig rig(rig_with_white(2000));
  rig.measure(sphere(3.0), 100);
  for (int y = 0; y < rig.height; ++y) {
    rig.pmd.maps.amp2.at(12, y) = kDim;
    rig.pmd.maps.distance.at(12, y) = 20000;
  }
  rig.resolve_without_stereo();
  EXPECT_TRUE(rig.flagged(12, 9));
  EXPECT_EQ(rig.pmd.maps.flags.at(5, 9) & kPmdEdge, 0);
  EXPECT_TRUE(rig.flagged(11, 9) || (rig.pmd.maps.flags.at(11, 9) & kPmdEdge) != 0);
}

TEST(Unwrap, WorksOnOnePixel) {
  UnwrapRig rig(rig_with_white(2000, 1, 1));
  rig.measure(sphere(3.0), 200);
  rig.resolve_without_stereo();
  EXPECT_EQ(rig.at(0, 0), 12000);
  rig.measure(sphere(3.0), kDim);
  rig.match(sphere(3.0));
  rig.resolve();  // one reading is nothing to confirm another by
  EXPECT_TRUE(rig.flagged(0, 0));
  rig.measure(kNothing, 0);
  rig.resolve();
  EXPECT_EQ(rig.at(0, 0), 0);
}

TEST(Unwrap, DoesNotRememberTheLastFrame) {
  UnwrapRig rig(rig_with_white(2000));
  UnwrapRig fresh(rig_with_white(2000));
  rig.measure(sphere(3.0), kDim);
  rig.match(sphere(3.0));
  rig.resolve();
  for (UnwrapRig* each : {&rig, &fresh}) {
    each->measure([](double x, double y) { return 2.0 + 0.3 * x + 0.1 * y; }, 60);
    each->match([](double x, double y) { return x < 17 ? 2.0 + 0.3 * x + 0.1 * y : 0.0; });
    each->resolve();
  }
  EXPECT_EQ(rig.pmd.distance, fresh.pmd.distance);
  EXPECT_EQ(rig.pmd.flags, fresh.pmd.flags);
  EXPECT_GT(fresh.share_flagged(), 0.0);
}

// Axes that converge by 0 degrees: depth comes from both columns.
TEST(Unwrap, WorksOnARigThatIsNotRectified) {
  Calibration calibration = rig_with_white(2000);
  constexpr double kPixel = 5e-6;
  const double focal = calibration.stereo.left.fx * kPixel;
  const double centre = calibration.stereo.left.cx;
  calibration.stereo.converging = Converging{
      .f1_m = focal, .f2_m = focal, .pixel_m = kPixel, .cx_left = centre, .cx_right = centre};
  ASSERT_STREQ(complete(calibration.stereo), "");
  UnwrapRig rig(calibration);
  rig.measure(sphere(3.0 + kRange), kDim);
  rig.match(sphere(3.0 + kRange));
  rig.resolve();
  EXPECT_GT(rig.share_right(sphere(3.0 + kRange)), 0.9);  // no columns at the left border
  rig.measure(sphere(3.0), kDim);
  rig.match(sphere(3.0));
  rig.resolve();
  EXPECT_EQ(rig.at(14, 9), 12000);
}

// Three ranges of 60 MHz lie within 8 m.
TEST(Unwrap, TellsManyWrapCountsApart) {
  Calibration calibration = rig_with_white(2000);
  calibration.pmd.frequency.modulation = Hertz{60'000'000};
  UnwrapRig rig(calibration, 32000);
  constexpr int kShort = 9993;
  rig.measure(sphere(6.0), kDim);
  for (int y = 0; y < rig.height; ++y) {
    for (int x = 0; x < rig.width; ++x) {
      rig.pmd.maps.distance.at(x, y) = 24000 - 2 * kShort;
    }
  }
  rig.pmd.maps.range = kShort;
  rig.pmd.maps.widest = kShort / 2;
  rig.match(sphere(6.0));
  rig.resolve();
  EXPECT_EQ(rig.share_right(sphere(6.0)), 1.0);
}

}  // namespace
}  // namespace stof::dsp
