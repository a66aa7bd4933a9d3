#include "hal/emu/scenes/boards.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "hal/emu/imagery/board_motion.h"
#include "hal/emu/imagery/grey.h"
#include "hal/emu/imagery/lens_rays.h"
#include "hal/emu/imagery/rendered_scene.h"
#include "hal/emu/scenes/poses.h"
#include "tests/hal/scenes/small_rigs.h"

namespace stof::test {
namespace {

using namespace hal::emu;

// A pair that is no perfect one: lenses that bend, a right camera turned by two degrees.
Rig raw_rig() {
  Rig rig = corridor_rig();
  rig.left_camera_pose = {};
  dsp::Pinhole left = rig.stereo.left;
  left.fx = 612;
  left.cy = 243.5;
  left.k1 = -0.22;
  left.k2 = 0.09;
  left.p1 = 0.001;
  left.p2 = -0.0006;
  left.k3 = 0.01;
  dsp::Pinhole right = left;
  right.fy = 618;
  right.cx = 311;
  right.cy = 246.5;
  right.k1 = -0.18;
  const Pose turn = turned(half_tangent(1.2), half_tangent(-1.0), half_tangent(1.1));
  rig.stereo.raw = dsp::RawPair{
      .left = left,
      .right = right,
      .left_to_right = {.rotation = turn.rotation, .translation_m = {-0.12, 0.002, 0.003}}};
  EXPECT_STREQ(dsp::complete(rig.stereo), "");
  return rig;
}

struct Pixel {
  double u = 0;
  double v = 0;
};

// R X + T, then Brown's model: nothing of the emulator's.
Pixel by_formula(const dsp::Pinhole& lens, const dsp::RigidTransform& t, const Vec3& point) {
  const std::array<double, 3> p{point.x, point.y, point.z};
  std::array<double, 3> q{};
  for (std::size_t i = 0; i < 3; ++i) {
    q[i] = t.translation_m[i] + t.rotation[3 * i] * p[0] + t.rotation[3 * i + 1] * p[1] +
           t.rotation[3 * i + 2] * p[2];
  }
  const double x = q[0] / q[2];
  const double y = q[1] / q[2];
  const double r2 = x * x + y * y;
  const double radial = 1 + lens.k1 * r2 + lens.k2 * r2 * r2 + lens.k3 * r2 * r2 * r2;
  return {lens.fx * (x * radial + 2 * lens.p1 * x * y + lens.p2 * (r2 + 2 * x * x)) + lens.cx,
          lens.fy * (y * radial + lens.p1 * (r2 + 2 * y * y) + 2 * lens.p2 * x * y) + lens.cy};
}

constexpr double kCell = 0.005;

// How far the levels of a dot of one cell are from the shares of pixels that the formula says: of
// the sum over its pixels, in shares of a pixel; and how far its centre is, px. The shares come
// from kSteps^2 points of the cell, each of which falls into one pixel.
struct Miss {
  double share = 0;
  double centre = 0;
};
Miss miss_of_dot(const dataset::Image<std::uint16_t>& picture, const dsp::Pinhole& lens,
                 const dsp::RigidTransform& to_camera, const Vec3& dot) {
  constexpr int kSteps = 300;
  constexpr int kReach = 6;
  const auto at = [&](double dx, double dy) {
    return by_formula(lens, to_camera, dot + Vec3{dx * kCell, dy * kCell, 0});
  };
  const Pixel middle = at(0, 0);
  const int u0 = static_cast<int>(std::lround(middle.u)) - kReach;
  const int v0 = static_cast<int>(std::lround(middle.v)) - kReach;
  const double area = (at(0.5, 0).u - at(-0.5, 0).u) * (at(0, 0.5).v - at(0, -0.5).v) -
                      (at(0.5, 0).v - at(-0.5, 0).v) * (at(0, 0.5).u - at(0, -0.5).u);
  constexpr std::size_t kSide = 2 * kReach + 1;
  std::array<double, kSide * kSide> shares{};
  for (int j = 0; j < kSteps; ++j) {
    for (int i = 0; i < kSteps; ++i) {
      const Pixel p = at((i + 0.5) / kSteps - 0.5, (j + 0.5) / kSteps - 0.5);
      const std::size_t x = static_cast<std::size_t>(std::lround(p.u) - u0);
      const std::size_t y = static_cast<std::size_t>(std::lround(p.v) - v0);
      shares[y * kSide + x] += area / (kSteps * kSteps);
    }
  }
  const double paper = picture.view().at(u0, v0);
  const double ink = 4 * 128;
  Miss miss;
  Pixel off;
  for (std::size_t y = 0; y < kSide; ++y) {
    for (std::size_t x = 0; x < kSide; ++x) {
      const double level = picture.view().at(u0 + static_cast<int>(x), v0 + static_cast<int>(y));
      const double error = (paper - level) / (paper - ink) - shares[y * kSide + x];
      miss.share = std::max(miss.share, std::abs(error));
      off.u += error * (static_cast<double>(x) - kReach) / area;
      off.v += error * (static_cast<double>(y) - kReach) / area;
    }
  }
  miss.centre = std::hypot(off.u, off.v);
  return miss;
}

// Nine dots over the picture, seen by both raw cameras: the whole chain of lens, rotation,
// translation and sampling, against the formula. Dots are 5 mm wide, 4 px.
TEST(RawPair, ShowsAPointWhereTheFormulaSays) {
  const Rig rig = raw_rig();
  const Sensors sensors(rig);
  Print dots{.columns = 201, .rows = 161, .cell_m = 0.005, .cells = {}};
  dots.cells.assign(std::size_t{201} * 161, 255);
  const auto cell = [&](int x, int y) { return static_cast<std::size_t>(y * 201 + x); };
  std::vector<std::pair<int, int>> places;
  for (const int y : {50, 80, 110}) {
    for (const int x : {60, 110, 150}) {
      dots.cells[cell(x, y)] = 0;
      places.emplace_back(x, y);
    }
  }
  const Eye left = left_eye(rig);
  const Pose sheet = left.pose * Pose{.rotation = Pose{}.rotation, .position = {0.03, 0.01, 0.8}};
  Scene scene;
  scene.ambient = 0.6;
  scene.objects.push_back(
      {.shape = Shape::kRectangle,
       .pose = sheet,
       .half = {201 * 0.0025, 161 * 0.0025, 0},
       .material = {.albedo = 0.9, .contrast = 1, .texture = Texture::kPrint, .print = &dots}});
  const CleanViews views = sensors.render(scene);
  for (const auto& [x, y] : places) {
    // In the axes of the left camera as it is.
    const Vec3 point{0.03 + (x - 100) * 0.005, 0.01 + (y - 80) * 0.005, 0.8};
    const Miss left_miss = miss_of_dot(views.left, rig.stereo.raw->left, {}, point);
    const Miss right_miss =
        miss_of_dot(views.right, rig.stereo.raw->right, rig.stereo.raw->left_to_right, point);
    for (const Miss& miss : {left_miss, right_miss}) {
      EXPECT_LT(miss.share, 0.02) << x << " " << y;
      EXPECT_LT(miss.centre, 0.01) << x << " " << y;
    }
  }
}

// Depths are those of the rectified left camera: a plane across its axis is equally far everywhere.
TEST(RawPair, DepthIsThatOfTheRectifiedView) {
  const Rig rig = raw_rig();
  const Sensors sensors(rig);
  for (const float z : sensors.depth(wall(2)).pixels) {
    ASSERT_EQ(z, 2.0F);
  }
  EXPECT_STREQ(dsp::problem(sensors.calibration()), "");
}

TEST(ChapterRig, MeetsAtFourMetresAndFollowsTheChaptersFormula) {
  const Rig rig = chapter_rig();
  EXPECT_STREQ(dsp::problem(Sensors(rig).calibration()), "");
  const Eye left = left_eye(rig);
  const Eye right = right_eye(rig);
  EXPECT_NEAR(left.lens.fx, 8.5e-3 / 5.6e-6, 1e-9);
  const double yaw = std::atan(0.10 / 4);
  for (const double z : {1.6, 2.4, 4.0}) {
    const Vec3 point{0.1, 0, z};  // between the two
    const Vec3 in_left = left.pose.undo(point);
    const Vec3 in_right = right.pose.undo(point);
    const double x_left = left.lens.fx * in_left.x / in_left.z;
    const double x_right = right.lens.fx * in_right.x / in_right.z;
    // Z = b / (T_r - T_l), with the angles of SPEC: counted towards the left.
    const double t_right = std::tan(yaw + std::atan(-x_right / right.lens.fx));
    const double t_left = std::tan(-yaw + std::atan(-x_left / left.lens.fx));
    EXPECT_NEAR(0.20 / (t_right - t_left), z, 1e-9);
    if (z == 4.0) {
      EXPECT_NEAR(x_left, 0, 1e-9);
      EXPECT_NEAR(x_right, 0, 1e-9);
    }
  }
  const Sensors sensors(rig);
  for (const float z : sensors.depth(wall(2)).pixels) {
    ASSERT_NEAR(z, 2.0F, 1e-6F);  // of the raw left pixels, across the baseline
  }
}

TEST(Chessboard, HasItsSquaresWhereItsCornersSay) {
  const Board board = chessboard(9, 6, 0.04);
  const Print& print = *board.print;
  EXPECT_EQ(print.columns, 12);
  EXPECT_EQ(print.rows, 9);
  // Around each inner corner the squares differ, and the first one is dark at its top left.
  for (int j = 0; j < 6; ++j) {
    for (int i = 0; i < 9; ++i) {
      const Vec3 corner = board.origin + Vec3{i * 0.04, j * 0.04, 0};
      const auto level = [&](double dx, double dy) {
        return print.brightness(corner + Vec3{dx, dy, 0});
      };
      const double first = (i + j) % 2 == 0 ? 0 : 1;
      EXPECT_EQ(level(-0.01, -0.01), first);
      EXPECT_EQ(level(0.01, 0.01), first);
      EXPECT_EQ(level(0.01, -0.01), 1 - first);
      EXPECT_EQ(level(-0.01, 0.01), 1 - first);
    }
  }
  EXPECT_EQ(print.brightness({-board.half.x + 0.01, 0, 0}), 1);  // the margin
}

TEST(Print, IsWhatTheFileSays) {
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "stof_print.pgm";
  dataset::Image<std::uint8_t> picture(3, 2);
  picture.pixels = {0, 255, 128, 64, 32, 200};
  ASSERT_TRUE(dataset::write_pgm8(file, picture));
  const auto board = parse_board("board:print," + file.string() + ",2.5");
  ASSERT_TRUE(board) << board.error();
  EXPECT_EQ(board->print->cells, picture.pixels);
  EXPECT_NEAR(board->half.x, 0.00375, 1e-12);
  EXPECT_NEAR(board->half.y, 0.0025, 1e-12);
  std::filesystem::remove(file);
  EXPECT_FALSE(parse_board("board:print," + file.string() + ",2.5"));
}

TEST(Boards, RefuseWhatMeansNothing) {
  for (const char* const name :
       {"board:", "board:chess", "board:chess,9x6", "board:chess,9,6,0.04", "board:chess,1x6,0.04",
        "board:chess,9x61,0.04", "board:chess,9x6,0", "board:chess,9x6,nan", "board:chess,9x6,2",
        "board:print,", "board:print,x.pgm", "board:print,x.pgm,0", "board:april,6x6"}) {
    const auto board = parse_board(name);
    ASSERT_FALSE(board) << name;
    EXPECT_EQ(board.error().find('\n'), std::string::npos);
  }
  for (const char* const poses :
       {"wave", "wave:", "wave:0,1", "wave:201,1", "wave:5", "wave:5,x",
        "tilts:", "distances:", "distances:0", "distances:1,,2", "turn"}) {
    EXPECT_FALSE(parse_poses(poses)) << poses;
  }
}

TEST(Wave, ShowsEveryKindToBothCameras) {
  const Board board = chessboard(9, 6, 0.04);
  for (const Rig& rig : {raw_rig(), chapter_rig()}) {
    for (std::uint32_t seed = 1; seed <= 5; ++seed) {
      const PoseScript script{.count = 20, .seed = seed};
      const std::vector<BoardPose> poses = poses_of(script, board, rig);
      const std::vector<BoardPose> again = poses_of(script, board, rig);
      std::map<std::string, int> kinds;
      std::map<std::string, double> away;
      int steep = 0;
      for (std::size_t i = 0; i < poses.size(); ++i) {
        const Pose& pose = poses[i].pose;
        EXPECT_EQ(pose.rotation, again[i].pose.rotation);
        for (const Eye& eye : {left_eye(rig), right_eye(rig)}) {
          EXPECT_TRUE(sees_pattern(eye.lens, eye.pose, board, pose)) << seed << " " << i;
        }
        ++kinds[poses[i].kind];
        away[poses[i].kind] += pose.position.z / 4;
        steep += pose.rotation[8] < std::cos(20 * 3.14159 / 180) ? 1 : 0;
      }
      EXPECT_EQ(kinds.size(), 5U);
      EXPECT_LT(1.2 * away["near"], away["far"]) << "the baseline keeps near ones away";
      EXPECT_GE(steep, 7);
    }
  }
}

TEST(Poses, OfDistancesAreExactAndAcrossTheAxis) {
  const auto script = parse_poses("distances:1.6,2.25,4");
  ASSERT_TRUE(script);
  const std::vector<BoardPose> poses = poses_of(*script, plane(), chapter_rig());
  ASSERT_EQ(poses.size(), 3U);
  EXPECT_EQ(poses[1].pose.position.z, 2.25);
  EXPECT_EQ(poses[1].pose.rotation, Pose{}.rotation);
}

TEST(Poses, BetweenTwoTurnsEvenly) {
  const Pose from = turned(half_tangent(-20), half_tangent(10));
  Pose to = turned(half_tangent(30), half_tangent(10));
  to.position = {0.4, 0, 1};
  const Pose half = between(from, to, 0.5);
  const Pose expected = turned(half_tangent(5), half_tangent(10));
  // Half way along the shortest turn; both have one pitch, so it is not quite that of the yaws.
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_NEAR(half.rotation[i], expected.rotation[i], 0.02);
  }
  EXPECT_NEAR(half.position.x, 0.2, 1e-12);
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_NEAR(between(from, to, 0).rotation[i], from.rotation[i], 1e-12);
    EXPECT_NEAR(between(from, to, 1).rotation[i], to.rotation[i], 1e-12);
  }
}

// A bar of one dark cell that is passed at 1 m/s: 4 ms at 2 m, 615 px, are 1.23 px.
TEST(BoardMotion, BlursWhatMovesByItsWay) {
  Rig rig = small(corridor_rig());
  rig.left_camera_pose = {};
  dataset::Image<std::uint8_t> bar(41, 1, 255);
  bar.pixels[20] = 0;
  const Board board = printed_board(bar, 0.05);
  const double focal = rig.stereo.left.fx;
  BoardPose still{.kind = "still",
                  .pose = Pose{.rotation = Pose{}.rotation, .position = {-1.025, -0.025, 2}}};
  BoardPose moving = still;
  moving.velocity = {20, 0, 0};  // 80 mm, 6.1 px of the small picture
  const Motion motion = board_motion(board, {still, moving}, rig, {.hold = 1, .moves = 0});
  EXPECT_TRUE(motion.blurred[0].pair.empty());
  EXPECT_GT(motion.blurred[1].pair.size(), 10U);
  MovingScene scene(motion, rig);
  const auto spread = [&](std::uint32_t number) {
    dataset::Image<std::uint8_t> picture(rig.stereo.left.width, rig.stereo.left.height);
    double sum = 0;
    double first = 0;
    double second = 0;
    constexpr int kShots = 64;
    const int row = (rig.stereo.left.height - 1) / 2;
    for (int shot = 0; shot < kShots; ++shot) {
      scene.left(number + 2 * static_cast<std::uint32_t>(shot), picture.view());
      for (int x = 60; x < 100; ++x) {
        const int dark = picture.view().at(57, row) - picture.view().at(x, row);
        sum += dark;
        first += dark * x;
        second += dark * x * x;
      }
    }
    const double mean = first / sum;
    return std::pair(mean, second / sum - mean * mean);
  };
  const auto [place, width] = spread(0);
  const auto [moved_place, moved_width] = spread(1);
  EXPECT_NEAR(moved_place, place, 0.5);  // the pose is that of the middle of the exposure
  const double way = 20 * 0.004 * focal / 2;
  EXPECT_NEAR(moved_width - width, way * way / 12, 1.0);
  // The four samples see four places, a quarter of 16 ms apart.
  const WhileExposed& during = motion.blurred[1];
  for (std::size_t k = 0; k < 4; ++k) {
    const double seconds = 0.016 * (2.0 * static_cast<double>(k) + 1) / 8 - 0.002;
    EXPECT_NEAR(during.samples[k][0].pose.position.x, 20 * seconds, 1e-9);
  }
}

// What the background does not show is what a whole rendering shows, blur included.
TEST(BoardMotion, PartsOfASoftPictureAreThoseOfAWholeOne) {
  Rig rig = small(raw_rig());
  rig.lenses = {.blur_px = 1.1, .vignetting = 0.3};
  const Board board = chessboard(5, 4, 0.05);
  const std::vector<BoardPose> poses = poses_of({.count = 4, .seed = 3}, board, rig);
  const Motion motion = board_motion(board, poses, rig, {});
  MovingScene scene(motion, rig);
  for (const std::uint32_t number : {2U, 0U, 3U}) {
    RenderedScene whole(scene.scene(number), rig);
    EXPECT_EQ(hash(expose(scene, number)), hash(expose(whole, number))) << number;
  }
}

// Between two poses the pair's picture is blurred, and the PMD camera sees one moment.
TEST(BoardMotion, OnTheWayIsBlurredAndTheSamplesSeeItsMiddle) {
  const Rig rig = small(raw_rig());
  const Board board = chessboard(5, 4, 0.05);
  const std::vector<BoardPose> poses = poses_of({.count = 2, .seed = 3}, board, rig);
  MovingScene scene(board_motion(board, poses, rig, {.hold = 1, .moves = 1}), rig);
  RenderedScene whole(scene.scene(1), rig);
  const Exposed way = expose(scene, 1);
  const Exposed still = expose(whole, 1);
  EXPECT_NE(way.left.pixels, still.left.pixels);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(way.samples[k].pixels, still.samples[k].pixels);
  }
}

// Noise is the sensor's alone: blur and vignetting change levels, not how pixels vary.
TEST(RawPair, NoiseIsWhiteAndAsLargeAsTheLevelSays) {
  Rig rig = small(raw_rig());
  rig.lenses = {.blur_px = 1.5, .vignetting = 0.4};
  RenderedScene scene(wall(2), rig);
  const std::vector<std::uint16_t> sigmas = grey_noise(rig.grey);
  constexpr int kShots = 200;
  const int width = scene.stereo_size().width;
  std::vector<double> sum(static_cast<std::size_t>(width), 0.0);
  std::vector<double> square(static_cast<std::size_t>(width), 0.0);
  std::vector<double> beside(static_cast<std::size_t>(width), 0.0);
  dataset::Image<std::uint8_t> picture(width, scene.stereo_size().height);
  for (std::uint32_t shot = 0; shot < kShots; ++shot) {
    scene.left(shot, picture.view());
    const auto row = picture.view().row(40);
    for (std::size_t x = 0; x < row.size(); ++x) {
      const double value = row[x];
      sum[x] += value / kShots;
      square[x] += value * value / kShots;
      beside[x] += x > 0 ? value * row[x - 1] / kShots : 0;
    }
  }
  double ratio = 0;
  double correlation = 0;
  for (std::size_t x = 1; x < sum.size(); ++x) {
    const double variance = square[x] - sum[x] * sum[x];
    const double sigma = sigmas[static_cast<std::size_t>(sum[x])] / 128.0;
    ratio += variance / (sigma * sigma + 1.0 / 12) / (width - 1);  // rounding to a level
    correlation += (beside[x] - sum[x] * sum[x - 1]) / variance / (width - 1);
  }
  EXPECT_NEAR(ratio, 1, 0.05);
  EXPECT_NEAR(correlation, 0, 0.03);
}

}  // namespace
}  // namespace stof::test
