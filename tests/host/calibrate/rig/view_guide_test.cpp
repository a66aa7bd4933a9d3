#include "host/calibrate/rig/live/view_guide.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "host/calibrate/rig/live/corner_cells.h"
#include "host/calibrate/rig/live/coverage_picture.h"
#include "host/calibrate/rig/live/picture_motion.h"
#include "host/calibrate/rig/live/sighting.h"
#include "tests/host/calibrate/rig/board_views.h"

namespace stof::host {
namespace {

using test::board_at;
using test::Gaussian;
using test::true_pair;

constexpr Board kGuided{.columns = 9, .rows = 6, .square_m = 0.03};
constexpr double kTilt = 0.4;  // rad

class Guided : public ::testing::Test {
 protected:
  // The board with its middle at a place, as both eyes see it; lenses known as roughly as told.
  Sighting at(const Vector3& middle, const Vector3& turn, double lens_error = 1.05) {
    PairView view = test::view_of(rig_, kGuided, board_at(kGuided, middle, turn), 0.02, random_);
    view.name = "view";
    dsp::Pinhole lens = assumed_lens(rig_.left.width, rig_.left.height);
    lens.fx = lens.fy = lens_error * rig_.left.fx;
    Sighting seen = sighting_of(std::move(view), kGuided, lens);
    seen.left_blur_px = seen.right_blur_px = 0.8;
    return seen;
  }
  Sighting facing(double x = 0.05) { return at({x, 0, 0.6}, {0, 0, 0}); }
  ViewJudgement judge(const Sighting& seen) {
    return guide_.judge(seen, [&seen] { return seen; });
  }
  // Held there for two exposures.
  ViewVerdict hold(const Vector3& middle, const Vector3& turn) {
    judge(at(middle, turn));
    return judge(at(middle, turn)).verdict;
  }
  const ViewWant& want(const std::string& name) {
    wants_ = guide_.wants();
    const auto found = std::ranges::find(wants_, name, &ViewWant::name);
    EXPECT_NE(found, wants_.end()) << name;
    return *found;
  }

  dsp::RawPair rig_ = true_pair();
  Gaussian random_{3};
  ViewGuideOptions options_{.width = 640, .height = 480, .views = 3};
  ViewGuide guide_{options_};
  std::vector<ViewWant> wants_;
};

TEST_F(Guided, CornersAreCountedInCellsOfEachPicture) {
  // One in the upper left cell, one at the far edge, one that is not seen.
  const std::vector<PairView> views{
      {.name = "a", .left = {{-0.5, -0.5}, {639.5, 479.5}, kUnseen}, .right = {}},
      {.name = "b", .left = {{79.4, 79.4}}, .right = {{80, 80}}}};
  const CornerCells cells = corner_cells(views, 640, 480);
  EXPECT_EQ(cells.left.front(), 2);
  EXPECT_EQ(cells.left.back(), 1);
  EXPECT_EQ(cells.right[1 * CornerCells::kColumns + 1], 1);
  EXPECT_EQ(std::ranges::count(cells.left, 0), 46);
  EXPECT_EQ(std::ranges::count(cells.right, 0), 47);
}

TEST_F(Guided, AViewIsTakenWhenTheBoardHoldsStill) {
  EXPECT_EQ(judge(facing()).verdict, ViewVerdict::kMoving);
  const ViewJudgement still = judge(facing());
  EXPECT_EQ(still.verdict, ViewVerdict::kTaken);
  EXPECT_LT(still.motion_px, 0.1);
  EXPECT_EQ(guide_.views().size(), 1U);
}

TEST_F(Guided, WhatMovesByMoreThanTheBoundIsNot) {
  // 600 px of focal length, 0.6 m away: 1 mm is 1 px.
  judge(facing(0.050));
  const ViewJudgement moving = judge(facing(0.0513));
  EXPECT_EQ(moving.verdict, ViewVerdict::kMoving);
  EXPECT_NEAR(moving.motion_px, 1.3, 0.15);
  EXPECT_NE(verdict_text(moving, options_).find("hold still: corners move by 1."),
            std::string::npos);
  EXPECT_EQ(judge(facing(0.0520)).verdict, ViewVerdict::kTaken);
}

TEST_F(Guided, MotionCountsInTheEyeWhereItIsLarger) {
  PairView before{.name = "", .left = {{1, 1}, {9, 1}, {1, 9}, {9, 9}}, .right = {}};
  before.right = before.left;
  PairView now = before;
  for (PixelPoint& corner : now.right) {
    corner.v += 3;
  }
  EXPECT_DOUBLE_EQ(corner_motion(before, now).value_or(0), 3);
  now.right.clear();
  EXPECT_DOUBLE_EQ(corner_motion(before, now).value_or(1), 0);
  now.left[0] = kUnseen;  // three are too few to compare
  EXPECT_FALSE(corner_motion(before, now));
}

TEST_F(Guided, AnExposureWithoutABoardBeginsAnew) {
  judge(facing());
  EXPECT_EQ(judge(Sighting{}).verdict, ViewVerdict::kNoBoard);
  EXPECT_EQ(judge(facing()).verdict, ViewVerdict::kMoving);
}

TEST_F(Guided, BlurredViewsAreRefused) {
  judge(facing());
  Sighting blurred = facing();
  blurred.right_blur_px = 1.6;
  const ViewJudgement judgement = judge(blurred);
  EXPECT_EQ(judgement.verdict, ViewVerdict::kBlurred);
  EXPECT_NE(verdict_text(judgement, options_).find("by 1.6 px, 1.5 are allowed"),
            std::string::npos);
  blurred.right_blur_px = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(judge(blurred).verdict, ViewVerdict::kBlurred);
  EXPECT_EQ(judge(facing()).verdict, ViewVerdict::kTaken);
}

TEST_F(Guided, ItLooksCloselyOnlyWhereAViewWouldBeTaken) {
  int looks = 0;
  const auto judge_counted = [&](const Sighting& rough) {
    return guide_.judge(rough, [&] {
      ++looks;
      Sighting fine = rough;
      fine.corners.name = "fine";
      return fine;
    });
  };
  judge_counted(facing(0.05));  // nothing before it
  judge_counted(facing(0.07));  // moved
  EXPECT_EQ(looks, 0);
  EXPECT_EQ(judge_counted(facing(0.07)).verdict, ViewVerdict::kTaken);
  EXPECT_EQ(looks, 1);
  EXPECT_EQ(guide_.views().back().name, "fine");
  judge_counted(facing(0.07));  // known
  EXPECT_EQ(looks, 1);
}

TEST_F(Guided, APlaceCountsOnce) {
  EXPECT_EQ(hold({0.05, 0, 0.6}, {0, 0, 0}), ViewVerdict::kTaken);
  EXPECT_EQ(hold({0.06, 0, 0.6}, {0, 0, 0}), ViewVerdict::kKnown);
  EXPECT_EQ(hold({0.10, 0, 0.6}, {0, 0, 0}), ViewVerdict::kTaken);
}

TEST_F(Guided, OneEyeAloneCountsWhereItReachesACornerOfItsPicture) {
  EXPECT_EQ(hold({-0.12, -0.12, 0.6}, {0, 0, 0}), ViewVerdict::kTaken);
  ASSERT_FALSE(guide_.views().back().both());
  ASSERT_FALSE(guide_.views().back().left.empty());
  EXPECT_FALSE(want("corner 0").missing());
  EXPECT_TRUE(want("corner 4").missing());
  EXPECT_EQ(want("more").have, 0U);
  EXPECT_EQ(hold({-0.09, -0.10, 0.6}, {0, 0, 0}), ViewVerdict::kNeedless);
}

TEST_F(Guided, EachTiltIsItsOwnWantWhateverTheLensIsThoughtToBe) {
  // A turn about y that brings the right side (x positive) nearer is positive.
  const struct {
    const char* name;
    Vector3 turn;
  } cases[] = {{"left-away", {0, kTilt, 0}},
               {"right-away", {0, -kTilt, 0}},
               {"top-away", {-kTilt, 0, 0}},
               {"bottom-away", {kTilt, 0, 0}}};
  for (const double lens_error : {0.9, 1.1}) {
    for (const auto& [name, turn] : cases) {
      guide_ = ViewGuide(options_);
      const Vector3 middle(0.05, 0, 0.6);
      const Sighting seen = at(middle, turn, lens_error);
      ASSERT_TRUE(seen.pose);
      guide_.add(seen);
      for (const auto& other : cases) {
        EXPECT_EQ(want(other.name).have, other.name == name ? 1U : 0U)
            << other.name << " of " << name;
      }
      // By the corners themselves: the side that is away is the smaller one.
      const std::vector<PixelPoint>& corners = seen.corners.left;
      const auto length = [&](std::size_t a, std::size_t b) {
        return std::hypot(corners[a].u - corners[b].u, corners[a].v - corners[b].v);
      };
      const double left = length(0, 45);
      const double right = length(8, 53);
      const double top = length(0, 8);
      const double bottom = length(45, 53);
      const std::string word = name;
      EXPECT_TRUE(word == "left-away"    ? left < right
                  : word == "right-away" ? right < left
                  : word == "top-away"   ? top < bottom
                                         : bottom < top)
          << word;
    }
  }
}

TEST_F(Guided, NearAndFarAreToldApart) {
  guide_.add(at({0.05, 0, 0.38}, {0, 0, 0}));
  EXPECT_EQ(want("near").have, 1U);
  EXPECT_EQ(want("far").have, 0U);
  guide_.add(at({0.05, 0, 0.5}, {0, 0, 0}));
  EXPECT_EQ(want("far").have, 0U);
  guide_.add(at({0.05, 0, 0.9}, {0, 0, 0}));
  EXPECT_EQ(want("far").have, 1U);
}

TEST_F(Guided, AWaveCompletesItAndItSaysSoOnTheWay) {
  options_.views = 20;
  guide_ = ViewGuide(options_);
  std::size_t missing = 100;
  Gaussian random(5);
  for (const PoseUnknowns& pose : test::waved_poses(rig_, kGuided, 120, 7)) {
    for (int exposure = 0; exposure < 2; ++exposure) {
      Sighting seen = sighting_of(test::view_of(rig_, kGuided, pose, 0.05, random), kGuided,
                                  assumed_lens(640, 480));
      seen.left_blur_px = seen.right_blur_px = 0.8;
      judge(seen);
    }
    const std::vector<ViewWant> wants = guide_.wants();
    const auto left = static_cast<std::size_t>(std::ranges::count_if(wants, &ViewWant::missing));
    EXPECT_LE(left, missing);  // what was shown stays shown, but `far`, which asks for the nearest
    missing = std::max(left, std::size_t{2});
    EXPECT_EQ(guide_.complete(), left == 0);
    EXPECT_EQ(missing_text(wants, 2).empty(), left == 0);
    if (guide_.complete()) {
      break;
    }
  }
  EXPECT_TRUE(guide_.complete()) << missing_text(guide_.wants(), 9);
  guide_.want_more(3);
  EXPECT_EQ(want("more").need, want("more").have + 3);
  EXPECT_EQ(missing_text(guide_.wants(), 2), "more: the board anywhere, before both cameras (" +
                                                 std::to_string(want("more").have) + " of " +
                                                 std::to_string(want("more").need) + ")");
}

TEST_F(Guided, WhatIsMissingIsToldInWords) {
  EXPECT_EQ(missing_text(guide_.wants(), 1).substr(0, 5), "near:");
  EXPECT_NE(missing_text(guide_.wants(), 2).find("; and 13 more"), std::string::npos)
      << missing_text(guide_.wants(), 2);
}

TEST_F(Guided, TheCoveragePictureShowsCornersAndZones) {
  constexpr Rgb kReached{205, 232, 210};
  constexpr Rgb kMissing{245, 205, 200};
  hold({-0.12, -0.12, 0.6}, {0, 0, 0});  // upper left of the left picture alone
  const dataset::Image<Rgb> picture =
      coverage_picture(guide_.views(), guide_.wants(), options_.width, options_.height);
  ASSERT_GT(picture.width, 640);
  const auto count = [&](const Rgb& colour, int from, int to) {
    int pixels = 0;
    for (int y = 0; y < picture.height; ++y) {
      for (int x = from; x < to; ++x) {
        pixels += picture.view().at(x, y) == colour ? 1 : 0;
      }
    }
    return pixels;
  };
  EXPECT_GT(count(kReached, 0, picture.width / 2), 1000);
  EXPECT_EQ(count(kReached, picture.width / 2, picture.width), 0);
  EXPECT_GT(count(kMissing, picture.width / 2, picture.width), 4000);
}

TEST(PictureMotion, IsHowFarTheTextureMoved) {
  const auto picture = [](int dx, int dy) {
    dataset::Image<std::uint8_t> made(320, 240);
    for (int y = 0; y < made.height; ++y) {
      for (int x = 0; x < made.width; ++x) {
        const double u = x - dx, v = y - dy;
        made.view().at(x, y) = static_cast<std::uint8_t>(
            128 + 50 * std::sin(0.21 * u + 0.05 * v) * std::cos(0.17 * v) +
            40 * std::sin(0.13 * u - 0.23 * v + 0.002 * u * v));
      }
    }
    return made;
  };
  EXPECT_NEAR(picture_motion(picture(0, 0), picture(0, 0)).value_or(9), 0, 0.05);
  EXPECT_NEAR(picture_motion(picture(0, 0), picture(3, -4)).value_or(9), 5, 0.1);
  const dataset::Image<std::uint8_t> flat(320, 240, 90);
  EXPECT_FALSE(picture_motion(flat, flat));
  EXPECT_FALSE(picture_motion(flat, dataset::Image<std::uint8_t>(64, 48, 90)));
}

}  // namespace
}  // namespace stof::host
