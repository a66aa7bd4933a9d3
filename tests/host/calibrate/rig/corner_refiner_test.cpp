#include "host/calibrate/rig/target/corner_refiner.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/host/calibrate/rig/board_views.h"
#include "tests/host/calibrate/rig/rendered_plane.h"

namespace stof::host {
namespace {

using test::board_at;
using test::Gaussian;
using test::PlaneCamera;

Board named(const char* text) {
  const dataset::Loaded<Board> board = board_named(text);
  EXPECT_TRUE(board) << text;
  return board.value_or(Board{});
}

test::Texture texture_of(const Board& board) {
  return board.has_markers() ? test::print_of(board) : test::chessboard(board);
}

// Small, and each pixel the mean of 100 rays: edges are where they are to a hundredth of a pixel.
const PlaneCamera& camera() {
  static const PlaneCamera fine({.width = 320,
                                 .height = 240,
                                 .fx = 305,
                                 .fy = 304,
                                 .cx = 161,
                                 .cy = 118,
                                 .k1 = -0.21,
                                 .k2 = 0.07,
                                 .p1 = 0.0008,
                                 .p2 = -0.0006},
                                10);
  return fine;
}

// Corners as a finder gives them: off by up to a pixel.
std::vector<PixelPoint> begun(std::vector<PixelPoint> corners, Gaussian& random) {
  for (PixelPoint& corner : corners) {
    corner.u += random.between(-0.7, 0.7);
    corner.v += random.between(-0.7, 0.7);
  }
  return corners;
}

double rms(const std::vector<PixelPoint>& a, const std::vector<PixelPoint>& b) {
  double squares = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    squares += std::pow(a[i].u - b[i].u, 2) + std::pow(a[i].v - b[i].v, 2);
  }
  return std::sqrt(squares / static_cast<double>(2 * a.size()));
}

constexpr double kClosePx = 0.02;

TEST(CornerRefiner, FindsWhereEdgesOfEveryBoardCross) {
  Gaussian random(1);
  for (const char* const name : {"9x6:0.04", "charuco:9x6:0.04", "charuco:9x6:0.04:0.02:6x6",
                                 "charuco:9x6:0.04:0.036", "aprilgrid:4x3:0.06:0.3"}) {
    const Board board = named(name);
    for (const Vector3& turn : {Vector3(0, 0, 0.07), Vector3(0.5, -0.3, 0.1),
                                Vector3(0.1, 0.6, -0.2), Vector3(0, 0.1, 3.1)}) {
      const PoseUnknowns pose = board_at(board, Vector3(0.02, -0.02, 0.5), turn);
      const std::vector<PixelPoint> truth = test::seen_by(camera().lens(), pose, board, 0, random);
      ASSERT_FALSE(truth.empty());
      std::vector<PixelPoint> corners = begun(truth, random);
      refine_corners(camera().picture(pose, texture_of(board), 2, random), board, corners);
      EXPECT_LT(rms(corners, truth), kClosePx) << name << ": " << turn.transpose();
    }
  }
}

TEST(CornerRefiner, TakesBlurAndLightThatFallsOff) {
  Gaussian random(2);
  const Board board = named("charuco:9x6:0.04");
  const test::Texture print = texture_of(board);
  const test::Texture lit = [&](double x, double y) {
    return print(x, y) * std::exp(-2 * x + y);  // half from one side to the other
  };
  const PoseUnknowns pose = board_at(board, Vector3(0, 0, 0.5), Vector3(0.3, 0.3, 0));
  const std::vector<PixelPoint> truth = test::seen_by(camera().lens(), pose, board, 0, random);
  std::vector<PixelPoint> corners = begun(truth, random);
  refine_corners(camera().picture(pose, lit, 2, random), board, corners);
  EXPECT_LT(rms(corners, truth), kClosePx);
}

// How far corners are off on the mean, along the way from the picture's middle: what edges that are
// bent do alike to all of them, px.
double outwards(const std::vector<PixelPoint>& found, const std::vector<PixelPoint>& truth,
                const dsp::Pinhole& lens) {
  double sum = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Eigen::Vector2d way(truth[i].u - lens.cx, truth[i].v - lens.cy);
    sum += Eigen::Vector2d(found[i].u - truth[i].u, found[i].v - truth[i].v).dot(way.normalized());
  }
  return sum / static_cast<double>(truth.size());
}

TEST(CornerRefiner, BendsEdgesAsTheLensDoes) {
  Gaussian random(7);
  const Board board = named("9x6:0.06");
  const PlaneCamera bent(
      {.width = 176, .height = 144, .fx = 120, .fy = 120, .cx = 88, .cy = 72, .k1 = -0.25}, 10);
  const PoseUnknowns pose = board_at(board, Vector3(0, 0, 0.6), Vector3(0.1, 0.1, 0.1));
  const std::vector<PixelPoint> truth = test::seen_by(bent.lens(), pose, board, 0, random);
  ASSERT_FALSE(truth.empty());
  const dataset::Image<std::uint8_t> picture = bent.picture(pose, texture_of(board), 0.5, random);
  const std::vector<PixelPoint> given = begun(truth, random);
  std::vector<PixelPoint> straight = given;
  refine_corners(picture, board, straight);
  std::vector<PixelPoint> corners = given;
  refine_corners(picture, board, corners, {.lens = &bent.lens()});
  std::printf("figure: corners are off outwards by %.4f px, by %.4f px where edges are straight\n",
              outwards(corners, truth, bent.lens()), outwards(straight, truth, bent.lens()));
  EXPECT_LT(std::abs(outwards(corners, truth, bent.lens())), 0.003);
  EXPECT_GT(std::abs(outwards(straight, truth, bent.lens())), 0.01);
  EXPECT_LT(rms(corners, truth), kClosePx);
}

// The same from light that falls off by the same share everywhere.
TEST(CornerRefiner, IsNotDrawnToTheLight) {
  Gaussian random(9);
  const Board board = named("9x6:0.04");
  const test::Texture print = texture_of(board);
  const test::Texture lit = [&](double x, double y) { return print(x, y) * std::exp(-4 * x + y); };
  const PoseUnknowns pose = board_at(board, Vector3(0, 0, 0.5), Vector3(0.1, 0.1, 0.05));
  const std::vector<PixelPoint> truth = test::seen_by(camera().lens(), pose, board, 0, random);
  std::vector<PixelPoint> corners = begun(truth, random);
  refine_corners(camera().picture(pose, lit, 0.5, random), board, corners,
                 {.lens = &camera().lens()});
  double u = 0;
  double v = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    // Black squares above are white ones below: corners are drawn to opposite sides in turn.
    const double sign = (i / 9 + i % 9) % 2 == 0 ? 1 : -1;
    u += sign * (corners[i].u - truth[i].u) / static_cast<double>(truth.size());
    v += sign * (corners[i].v - truth[i].v) / static_cast<double>(truth.size());
  }
  std::printf("figure: corners are drawn by the light by %.4f and %.4f px\n", u, v);
  EXPECT_LT(std::hypot(u, v), 0.003);
  EXPECT_LT(rms(corners, truth), kClosePx);
}

// Squares of a board along one side of the picture, before a lamp whose light falls off as a
// Gaussian does: what a pixel collects of it, the squares counted by turns as more and as less, or
// all alike. Exact.
struct LitSide {
  double first = 0;   // corner
  double square = 0;  // px
  double lamp = 0;
  double reach = 0;

  double light(double begin, double end) const {
    const double scale = reach * std::numbers::sqrt2;
    return std::erf((end - lamp) / scale) - std::erf((begin - lamp) / scale);
  }
  double collected(int pixel, bool by_turns) const {
    const double end = pixel + 0.5;
    double sum = 0;
    for (double at = pixel - 0.5; at < end;) {
      const double number = std::floor((at - first) / square + 1e-9);
      const double next = std::min(end, first + (number + 1) * square);
      const bool even = std::fmod(std::abs(number), 2) == 0;
      sum += light(at, next) * (by_turns && even ? -1 : 1);
      at = next;
    }
    return sum;
  }
};

dataset::Image<float> lit_squares(const LitSide& x, const LitSide& y) {
  dataset::Image<float> picture(144, 104);
  for (int v = 0; v < picture.height; ++v) {
    for (int u = 0; u < picture.width; ++u) {
      const double turns = x.collected(u, true) * y.collected(v, true);
      const double light = x.collected(u, false) * y.collected(v, false);
      picture.view().at(u, v) =
          static_cast<float>(std::pow(x.reach * y.reach, 2) * (0.5 * light - 0.4 * turns));
    }
  }
  return picture;
}

// Slopes of the light that are not the same all over the window draw corners as one slope does:
// here all of them away from the lamp. What squares that lie along the pixels do is the same in
// even light.
TEST(CornerRefiner, IsNotDrawnByLightThatFallsOffFasterAndFaster) {
  const Board board = named("9x6:0.04");
  LitSide x{.first = 22.37, .square = 12.3, .lamp = 72, .reach = 40};
  LitSide y{.first = 20.81, .square = 12.3, .lamp = 50, .reach = 40};
  std::vector<PixelPoint> truth;
  for (int i = 0; i < board.corners(); ++i) {
    truth.push_back({.u = x.first + x.square * (i % board.columns),
                     .v = y.first + y.square * (i / board.columns)});
  }
  Gaussian random(10);
  std::vector<PixelPoint> lit = begun(truth, random);
  std::vector<PixelPoint> even = lit;
  EXPECT_EQ(std::ranges::count(refine_corners(lit_squares(x, y), board, lit), true),
            board.corners());
  x.reach = y.reach = 1e4;
  EXPECT_EQ(std::ranges::count(refine_corners(lit_squares(x, y), board, even), true),
            board.corners());
  const double drawn = outwards(lit, even, {.cx = x.lamp, .cy = y.lamp});
  std::printf("figure: corners are drawn away from the lamp by %.6f px\n", drawn);
  EXPECT_LT(std::abs(drawn), 2e-4);
  EXPECT_LT(rms(lit, truth), 0.003);
}

TEST(CornerRefiner, TakesSquaresOfFivePixels) {
  Gaussian random(3);
  const Board board = named("9x6:0.06");
  const PlaneCamera coarse({.width = 176, .height = 144, .fx = 160, .fy = 160, .cx = 88, .cy = 72},
                           10);
  const PoseUnknowns pose = board_at(board, Vector3(0.1, 0, 1.9), Vector3(0.2, 0.3, 0.1));
  const std::vector<PixelPoint> truth = test::seen_by(coarse.lens(), pose, board, 0, random);
  std::vector<PixelPoint> corners = begun(truth, random);
  refine_corners(coarse.picture(pose, texture_of(board), 2, random), board, corners);
  EXPECT_LT(rms(corners, truth), 0.04);
}

// How far the places scatter that fits to the same picture with other noise find.
struct Scatter {
  double squared = 0;   // of both coordinates, in their own covariances: 2 where these are true
  double sigma_px = 0;  // of one coordinate
};
Scatter scatter_of(const dataset::Image<std::uint8_t>& clean, const Board& board,
                   const std::vector<PixelPoint>& truth, double noise) {
  constexpr int kDraws = 12;
  std::vector<std::vector<PixelPoint>> draws;
  Gaussian random(6);
  for (int n = 0; n < kDraws; ++n) {
    dataset::Image<float> noisy(clean.width, clean.height);
    for (std::size_t i = 0; i < clean.pixels.size(); ++i) {
      noisy.pixels[i] = static_cast<float>(clean.pixels[i] + random.next(noise));
    }
    draws.push_back(truth);
    const std::vector<bool> fitted = refine_corners(noisy, board, draws.back());
    EXPECT_EQ(std::ranges::count(fitted, true), board.corners());
  }
  Scatter scatter;
  const auto all = static_cast<double>(truth.size() * (kDraws - 1));
  for (std::size_t i = 0; i < truth.size(); ++i) {
    PixelPoint mean;
    for (const std::vector<PixelPoint>& draw : draws) {
      mean.u += draw[i].u / kDraws;
      mean.v += draw[i].v / kDraws;
    }
    for (const std::vector<PixelPoint>& draw : draws) {
      const PixelPoint& p = draw[i];
      const double u = p.u - mean.u;
      const double v = p.v - mean.v;
      scatter.squared +=
          (p.vv * u * u - 2 * p.uv * u * v + p.uu * v * v) / (p.uu * p.vv - p.uv * p.uv) / all;
      scatter.sigma_px += (u * u + v * v) / 2 / all;
    }
  }
  scatter.sigma_px = std::sqrt(scatter.sigma_px);
  return scatter;
}

// Where grey values scatter much more than the model is off; what it is off makes corners count
// less.
TEST(CornerRefiner, TellsHowCertainEachCornerIs) {
  Gaussian random(8);
  for (const auto& [name, noise] : {std::pair("9x6:0.04", 5.0), std::pair("9x6:0.04", 10.0),
                                    std::pair("charuco:9x6:0.04", 10.0)}) {
    const Board board = named(name);
    const PoseUnknowns pose = board_at(board, Vector3(0, 0, 0.5), Vector3(0.5, 0.4, 0.1));
    const std::vector<PixelPoint> truth = test::seen_by(camera().lens(), pose, board, 0, random);
    const Scatter scatter =
        scatter_of(camera().picture(pose, texture_of(board), 0, random), board, truth, noise);
    std::printf("figure: %s, noise %g: corners scatter by %.3f px, normalised square %.2f of 2\n",
                name, noise, scatter.sigma_px, scatter.squared);
    EXPECT_NEAR(scatter.squared, 2, 0.4) << name << ", " << noise;
  }
}

TEST(CornerRefiner, LeavesWhatIsNoCornerAsItIs) {
  Gaussian random(4);
  const Board board = named("9x6:0.04");
  const PoseUnknowns pose = board_at(board, Vector3(0, 0, 0.5), Vector3(0.1, 0.1, 0));
  std::vector<PixelPoint> given = test::seen_by(camera().lens(), pose, board, 0, random);
  given[3] = kUnseen;
  std::vector<PixelPoint> corners = given;
  refine_corners(dataset::Image<std::uint8_t>(320, 240, 90), board, corners);
  for (std::size_t i = 0; i < given.size(); ++i) {
    EXPECT_EQ(corners[i].seen(), given[i].seen());
    EXPECT_TRUE(!given[i].seen() || (corners[i].u == given[i].u && corners[i].v == given[i].v))
        << i;
  }
  // Half of the board is hidden.
  dataset::Image<std::uint8_t> picture = camera().picture(pose, texture_of(board), 2, random);
  for (int v = 0; v < picture.height; ++v) {
    std::ranges::fill(picture.view().row(v).subspan(0, 150), std::uint8_t{90});
  }
  refine_corners(picture, board, corners);
  const std::vector<PixelPoint> truth = test::seen_by(camera().lens(), pose, board, 0, random);
  for (std::size_t i = 0; i < given.size(); ++i) {
    EXPECT_FALSE(corners[i].u > 162 &&
                 std::hypot(corners[i].u - truth[i].u, corners[i].v - truth[i].v) > 0.1)
        << i;
    EXPECT_FALSE(corners[i].u < 138 && corners[i].u != given[i].u) << i;
  }
  std::vector<PixelPoint> few(given.size(), kUnseen);
  refine_corners(picture, board, few);
  EXPECT_EQ(seen_corners(few), 0U);
}

TEST(CornerRefiner, FitsThoseThatAreAskedForAsItFitsAll) {
  Gaussian random(5);
  const Board board = named("9x6:0.04");
  const PoseUnknowns pose = board_at(board, Vector3(0, 0, 0.5), Vector3(0.1, 0.1, 0));
  const dataset::Image<std::uint8_t> picture = camera().picture(pose, texture_of(board), 2, random);
  const std::vector<PixelPoint> given =
      begun(test::seen_by(camera().lens(), pose, board, 0, random), random);
  std::vector<PixelPoint> all = given;
  EXPECT_EQ(std::ranges::count(refine_corners(picture, board, all), true), board.corners());
  std::vector<PixelPoint> some = given;
  std::vector<bool> asked(given.size());
  asked[7] = asked[30] = true;
  EXPECT_EQ(refine_corners(picture, board, some, {.asked = asked}), asked);
  for (std::size_t i = 0; i < given.size(); ++i) {
    const PixelPoint& wanted = asked[i] ? all[i] : given[i];
    EXPECT_TRUE(some[i].u == wanted.u && some[i].v == wanted.v) << i;
  }
}

}  // namespace
}  // namespace stof::host
