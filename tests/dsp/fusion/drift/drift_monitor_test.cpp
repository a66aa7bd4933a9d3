#include "dsp/fusion/drift/drift_monitor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "dsp/calib/stereo/column_tables.h"
#include "dsp/fusion/drift/plane_reader.h"
#include "tests/dsp/fusion/drift/drift_room.h"

namespace stof::dsp {
namespace {

constexpr int kFrames = 24;  // every patch three times

DriftEstimate watch(Room& room, const Calibration& rig) {
  Watch watch(rig);
  const PmdMaps maps = room.maps();
  for (int i = 0; i < kFrames; ++i) {
    watch.monitor.observe(room.pair(), maps);
  }
  return watch.monitor.estimate();
}

DriftEstimate find(const RoomDrift& drift) {
  const Calibration rig = room_rig();
  Room room(whole_room(), rig, drift);
  return watch(room, rig);
}

double degrees(const Drift& drift) { return drift.value * 1e-6 / kRadPerDegree; }
double millimetres(const Drift& drift) { return drift.value / 16.0; }

// Rounded grey values and disparities leave some thousandths of a degree; angles about several axes
// do not quite commute.
constexpr double kToleranceDeg = 0.008;
constexpr double kToleranceMm = 4;

void expect_found(const RoomDrift& drift) {
  const DriftEstimate found = find(drift);
  using enum DriftParameter;
  EXPECT_NEAR(degrees(found[kPitch]), drift.pitch_deg, kToleranceDeg);
  EXPECT_NEAR(degrees(found[kYaw]), drift.yaw_deg, kToleranceDeg);
  EXPECT_NEAR(degrees(found[kRoll]), drift.roll_deg, 2 * kToleranceDeg);
  EXPECT_NEAR(millimetres(found[kRange]), 1000 * drift.range_m, kToleranceMm);
  EXPECT_NEAR(found[kDisparity].value / 1000.0, drift.disparity_px, 0.03);
  EXPECT_EQ(found[kPitch].significant, drift.pitch_deg != 0);
  EXPECT_EQ(found[kYaw].significant, drift.yaw_deg != 0);
  EXPECT_EQ(found[kRoll].significant, drift.roll_deg != 0);
  EXPECT_EQ(found[kRange].significant, drift.range_m != 0);
  EXPECT_GE(found.patches, 50U);
}

TEST(DriftMonitor, FindsNothingWhereNothingDrifted) {
  const DriftEstimate found = find({});
  expect_found({});
  EXPECT_FALSE(found.significant);
}

TEST(DriftMonitor, FindsPitchOfEitherSign) {
  expect_found({.pitch_deg = 0.05});
  expect_found({.pitch_deg = -0.2});
}

TEST(DriftMonitor, FindsYawOfEitherSign) {
  expect_found({.yaw_deg = 0.2});
  expect_found({.yaw_deg = -0.05});
}

TEST(DriftMonitor, FindsRollOfEitherSign) {
  expect_found({.roll_deg = 0.15});
  expect_found({.roll_deg = -0.15});
}

TEST(DriftMonitor, FindsRangeOffsetOfEitherSign) {
  expect_found({.range_m = 0.03});
  expect_found({.range_m = -0.03});
}

TEST(DriftMonitor, TellsDriftsApartThatComeTogether) {
  expect_found({.pitch_deg = 0.1, .yaw_deg = -0.12, .roll_deg = 0.15, .range_m = 0.025});
}

TEST(DriftMonitor, DisparityOffsetIsNotTakenForATurn) {
  const DriftEstimate found = find({.disparity_px = 0.1});
  EXPECT_FALSE(found[DriftParameter::kPitch].significant);
  EXPECT_FALSE(found[DriftParameter::kYaw].significant);
  EXPECT_FALSE(found[DriftParameter::kRange].significant);
  EXPECT_NEAR(found[DriftParameter::kDisparity].value / 1000.0, 0.1, 0.05);
}

TEST(DriftMonitor, SaysNothingAboutWhatASceneDoesNotShow) {
  const Calibration rig = room_rig();
  Room room(floor_alone(), rig, {.pitch_deg = 0.2, .yaw_deg = 0.2});
  const DriftEstimate found = watch(room, rig);
  const Drift& yaw = found[DriftParameter::kYaw];  // about the floor's normal
  EXPECT_FALSE(yaw.significant);
  EXPECT_GT(yaw.sigma, 10 * kToleranceDeg * kRadPerDegree * 1e6);
}

TEST(DriftMonitor, FewReadingsAreUnknown) {
  const Calibration rig = room_rig();
  Room room(whole_room(), rig, {.pitch_deg = 0.2});
  std::fill(room.distance.begin() + std::ptrdiff_t{88 * 6}, room.distance.end(), kNoDepth);
  const DriftEstimate found = watch(room, rig);
  EXPECT_FALSE(found.significant);
  for (const Drift& drift : found.drifts) {
    EXPECT_GT(drift.sigma, 1000);  // or unknown
  }
}

TEST(DriftMonitor, FollowsADriftThatComesLater) {
  const Calibration rig = room_rig();
  Room before(whole_room(), rig, {});
  Room after(whole_room(), rig, {.yaw_deg = 0.1});
  Watch watch(rig, {.fade_frames = 40});
  for (int i = 0; i < 80; ++i) {
    watch.monitor.observe(before.pair(), before.maps());
  }
  EXPECT_FALSE(watch.monitor.estimate().significant);
  for (int i = 0; i < 160; ++i) {
    watch.monitor.observe(after.pair(), after.maps());
  }
  EXPECT_NEAR(degrees(watch.monitor.estimate()[DriftParameter::kYaw]), 0.1, kToleranceDeg);
  watch.monitor.forget();
  EXPECT_EQ(watch.monitor.estimate().patches, 0U);
  EXPECT_EQ(watch.monitor.estimate()[DriftParameter::kYaw].sigma, kDriftUnknown);
}

TEST(DriftMonitor, IgnoresWhatPassesBy) {
  const Calibration rig = room_rig();
  Room room(whole_room(), rig, {});
  Room other(whole_room(), rig, {});
  // In every sixth frame the PMD reads a third of its picture 20 cm nearer.
  for (std::size_t i = 0; i < other.distance.size(); ++i) {
    if (i % 88 < 30 && other.distance[i] > 0) {
      other.distance[i] = static_cast<QuarterMm>(other.distance[i] - 800);
    }
  }
  Watch watch(rig);
  for (int i = 0; i < 144; ++i) {
    Room& seen = i > 48 && i % 6 == 0 ? other : room;
    watch.monitor.observe(seen.pair(), seen.maps());
  }
  const DriftEstimate found = watch.monitor.estimate();
  EXPECT_FALSE(found.significant);
  EXPECT_NEAR(degrees(found[DriftParameter::kYaw]), 0, kToleranceDeg);
}

// A picture whose content has moved by `shift` columns when `now` is seen; borders replicate.
std::vector<std::uint8_t> before_it_moved(ImageView<const std::uint8_t> now, int shift) {
  std::vector<std::uint8_t> out;
  for (int y = 0; y < now.height(); ++y) {
    for (int x = 0; x < now.width(); ++x) {
      out.push_back(now.at(std::clamp(x + shift, 0, now.width() - 1), y));
    }
  }
  return out;
}

constexpr std::int32_t kPeriodUs = 33'333;
constexpr std::int32_t kLagUs = 6'000;
constexpr int kMoved = -7;  // px a period; at a focal length of 300 px 0.24 degrees in the lag
constexpr double kTurnedDeg = 0.2406;

// Turns to the right while the samples of such a room are taken.
DriftEstimate turn_before(Room& room, const Calibration& rig) {
  Watch watch(rig);
  const MatchedPair pair = room.pair();
  const std::vector<std::uint8_t> before = before_it_moved(pair.left, kMoved);
  for (int i = 0; i < kFrames; ++i) {
    watch.monitor.follow({before.data(), pair.left.width(), pair.left.height()}, 0);
    watch.monitor.follow(pair.left, kPeriodUs);
    watch.monitor.observe(pair, room.maps(), kLagUs);
  }
  return watch.monitor.estimate();
}

TEST(DriftMonitor, WhatARigTurnsByBetweenExposuresIsNoDrift) {
  const Calibration rig = room_rig();
  Room room(whole_room(), rig, {.yaw_deg = kTurnedDeg});
  EXPECT_TRUE(watch(room, rig)[DriftParameter::kYaw].significant);
  const DriftEstimate found = turn_before(room, rig);
  EXPECT_FALSE(found.significant);
  EXPECT_NEAR(degrees(found[DriftParameter::kYaw]), 0, 2 * kToleranceDeg);
  EXPECT_GE(found.patches, 50U);
}

TEST(DriftMonitor, FindsADriftWhileTheRigTurns) {
  const Calibration rig = room_rig();
  Room room(whole_room(), rig, {.yaw_deg = kTurnedDeg - 0.5, .range_m = 0.04});
  const DriftEstimate found = turn_before(room, rig);
  EXPECT_TRUE(found[DriftParameter::kYaw].significant);
  EXPECT_NEAR(degrees(found[DriftParameter::kYaw]), -0.5, 3 * kToleranceDeg);
  EXPECT_TRUE(found[DriftParameter::kRange].significant);
  EXPECT_NEAR(millimetres(found[DriftParameter::kRange]), 40, 2 * kToleranceMm);
}

TEST(DriftMonitor, AFrameWhoseTurnNobodyKnowsSaysNothing) {
  const Calibration rig = room_rig();
  Room room(whole_room(), rig, {});
  Watch watch(rig);
  for (int i = 0; i < kFrames; ++i) {
    watch.monitor.observe(room.pair(), room.maps(), kLagUs);  // no picture was followed
  }
  EXPECT_EQ(watch.monitor.estimate().patches, 0U);
  const std::vector<std::uint8_t> before = before_it_moved(room.pair().left, kMoved);
  for (int i = 0; i < kFrames; ++i) {
    watch.monitor.follow({before.data(), room.pair().left.width(), room.pair().left.height()}, 0);
    watch.monitor.follow(room.pair().left, 0);  // after a gap
    watch.monitor.observe(room.pair(), room.maps(), kLagUs);
  }
  EXPECT_EQ(watch.monitor.estimate().patches, 0U);
}

TEST(DriftMonitor, WhatMovesWithoutTurningMakesTheRangeUncertain) {
  const Calibration rig = room_rig();
  Room room(whole_room(), rig, {});
  std::array<std::int32_t, 2> sigma{};
  for (const bool moved : {false, true}) {
    Watch watch(rig);
    PmdMaps maps = room.maps();
    maps.moved = moved;
    for (int i = 0; i < kFrames; ++i) {
      watch.monitor.follow(room.pair().left, kPeriodUs);
      watch.monitor.observe(room.pair(), maps, kLagUs);
    }
    sigma[moved ? 1 : 0] = watch.monitor.estimate()[DriftParameter::kRange].sigma;
  }
  EXPECT_GT(sigma[1], sigma[0] + 16);  // by a millimetre and more
}

TEST(DriftMonitor, NothingToSeeIsHarmless) {
  const Calibration rig = room_rig();
  const Room room(whole_room(), rig, {.pitch_deg = 0.2});
  Room blank = room;
  std::ranges::fill(blank.distance, kNoDepth);
  EXPECT_EQ(watch(blank, rig).patches, 0U);
  blank = room;
  std::ranges::fill(blank.disparity, Disparity::none());
  EXPECT_EQ(watch(blank, rig).patches, 0U);
  blank = room;
  std::ranges::fill(blank.right, std::uint8_t{128});
  EXPECT_EQ(watch(blank, rig).patches, 0U);
}

TEST(DriftMonitor, HostileValuesAreHarmless) {
  const Calibration rig = room_rig();
  Room room(whole_room(), rig, {});
  for (const QuarterMm distance : {QuarterMm{1}, kMaxQuarterMm}) {
    std::ranges::fill(room.distance, distance);
    std::ranges::fill(room.sigma, kMaxQuarterMm);
    EXPECT_FALSE(watch(room, rig).significant);
    std::ranges::fill(room.disparity, Disparity::from_raw(32767));
    EXPECT_FALSE(watch(room, rig).significant);
    std::ranges::fill(room.disparity, Disparity::from_raw(-32767));
    EXPECT_FALSE(watch(room, rig).significant);
  }
}

TEST(DriftMonitor, PicturesOfOnePixelAndOfOtherSizesAreHarmless) {
  Calibration rig = room_rig();
  rig.stereo.left.width = rig.stereo.left.height = 1;
  rig.pmd.lens.width = rig.pmd.lens.height = 1;
  Room one(whole_room(), rig, {});
  EXPECT_FALSE(watch(one, rig).significant);
  EXPECT_EQ(watch(one, room_rig()).patches, 0U);  // maps of another size
  Room room(whole_room(), room_rig(), {});
  EXPECT_EQ(watch(room, rig).patches, 0U);
  Watch other(room_rig());
  for (int i = 0; i < kFrames; ++i) {
    other.monitor.observe(one.pair(), room.maps());
    other.monitor.observe({}, room.maps());
    other.monitor.observe(room.pair(), {});
  }
  EXPECT_EQ(other.monitor.estimate().patches, 0U);
  rig.pmd.lens.width = rig.pmd.lens.height = 0;
  EXPECT_EQ(watch(room, rig).patches, 0U);
}

TEST(DriftMonitor, ParallelAxesAreTheSameWhenWrittenAsConverging) {
  Calibration rig = room_rig();
  Room room(whole_room(), rig, {.pitch_deg = 0.1});
  const DriftEstimate plain = watch(room, rig);
  rig.stereo.converging = {.alpha_rad = 0,
                           .beta_rad = 0,
                           .f1_m = 0.003,
                           .f2_m = 0.003,
                           .pixel_m = 1e-5,
                           .cx_left = 160,
                           .cx_right = 160};
  const DriftEstimate converging = watch(room, rig);
  for (std::size_t k = 0; k < kDriftParameters; ++k) {
    EXPECT_NEAR(converging.drifts[k].value, plain.drifts[k].value, 2) << k;
  }
}

TEST(PlaneReader, AQuarterOfAPatchMayBeMissingWhereSomethingMoved) {
  const Calibration rig = room_rig();
  Room room({{2, 3.0}}, rig, {});
  test::GuardedPart<PlaneReader> reader([&](Arena& arena) { return PlaneReader(rig, arena); });
  const int side = reader->side();
  const auto drop = [&](int count) {  // from the patch's first reading on
    for (int i = 0; i < count; ++i) {
      const std::size_t at = static_cast<std::size_t>(i / side * 88 + i % side);
      room.flags[at] = i % 2 == 0 ? kPmdAsymmetric : kPmdLowRatio;
      room.distance[at] = kNoDepth;
    }
  };
  PmdMaps maps = room.maps();
  drop(side * side / 4);
  EXPECT_FALSE(reader->read(0, 0, maps));
  maps.moved = true;
  const std::optional<ExpectedPlane> plane = reader->read(0, 0, maps);
  ASSERT_TRUE(plane);
  EXPECT_NEAR(depth_of(rig.stereo, plane->u, plane->d), 3.0, 0.003);
  drop(side * side / 4 + 1);
  EXPECT_FALSE(reader->read(0, 0, maps));
}

TEST(PlaneReader, NoisyReadingsCountLessWhereSomethingMoved) {
  const Calibration rig = room_rig();
  Room room({{2, 3.0}}, rig, {});
  test::GuardedPart<PlaneReader> reader([&](Arena& arena) { return PlaneReader(rig, arena); });
  for (std::size_t y = 0; y < 6; ++y) {
    room.distance[88 * y + 2 * (y % 3)] += 400;  // 10 cm too far, and it says so
    room.sigma[88 * y + 2 * (y % 3)] = 400;
  }
  PmdMaps maps = room.maps();
  maps.moved = true;
  const std::optional<ExpectedPlane> plane = reader->read(0, 0, maps);
  ASSERT_TRUE(plane);
  EXPECT_NEAR(depth_of(rig.stereo, plane->u, plane->d), 3.0, 0.004);
  maps.moved = false;
  EXPECT_FALSE(reader->read(0, 0, maps));  // they do not lie on a plane
}

// The disparity that is expected of a plane is that of the depth formula of its rig.
TEST(PlaneReader, ExpectsTheDisparityOfConvergingAxes) {
  Calibration rig = room_rig();
  rig.pmd_to_stereo = {};
  rig.stereo.converging = {.alpha_rad = 0.03,
                           .beta_rad = -0.02,
                           .f1_m = 0.0031,
                           .f2_m = 0.003,
                           .pixel_m = 1e-5,
                           .cx_left = 158,
                           .cx_right = 161};
  Room room({{2, 3.0}}, rig, {});
  test::GuardedPart<PlaneReader> reader([&](Arena& arena) { return PlaneReader(rig, arena); });
  for (const int x : {0, 30, 80}) {
    const std::optional<ExpectedPlane> plane = reader->read(x, 12, room.maps());
    ASSERT_TRUE(plane);
    EXPECT_NEAR(depth_of(rig.stereo, plane->u, plane->d), 3.0, 0.003) << x;
  }
}

}  // namespace
}  // namespace stof::dsp
