#include "host/picture/plot/plot.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "host/picture/plot/plot_map.h"
#include "host/picture/plot/plot_text.h"

namespace stof::host {
namespace {

constexpr Rgb kWhite{255, 255, 255};
constexpr Rgb kRed{255, 0, 0};

std::vector<std::pair<int, int>> pixels_of(const dataset::Image<Rgb>& picture, Rgb colour) {
  std::vector<std::pair<int, int>> found;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      if (picture.view().row(y)[static_cast<std::size_t>(x)] == colour) {
        found.emplace_back(x, y);
      }
    }
  }
  return found;
}

Plot dots(std::vector<double> x, std::vector<double> y) {
  return {.title = "t",
          .x_label = "x",
          .y_label = "y",
          .series = {{.name = "",
                      .x = std::move(x),
                      .y = std::move(y),
                      .colour = kRed,
                      .line = false,
                      .dot_px = 7}}};
}

TEST(RoundTicks, AreRoundAndWithin) {
  EXPECT_EQ(round_ticks(0, 10, 5), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  EXPECT_EQ(round_ticks(-1.1, 1.1, 4), (std::vector<double>{-1, 0, 1}));
  const std::vector<double> small = round_ticks(0.031, 0.0495, 4);
  ASSERT_EQ(small.size(), 3U);
  EXPECT_NEAR(small[0], 0.035, 1e-12);
  EXPECT_NEAR(small[2], 0.045, 1e-12);
}

TEST(PlotPicture, PutsDotsWhereNumbersSay) {
  const dataset::Image<Rgb> picture = plot_picture(dots({0, 1, 2}, {0, 1, 4}));
  EXPECT_EQ(picture.width, 900);
  const std::vector<std::pair<int, int>> red = pixels_of(picture, kRed);
  ASSERT_FALSE(red.empty());
  const auto [left, right] = std::ranges::minmax_element(red);
  const auto x_of = [&](double share) {
    return left->first + share * (right->first - left->first);
  };
  // The middle dot is half way to the right and a quarter of the way up.
  double y_sum = 0;
  double count = 0;
  int bottom = 0;
  int top = picture.height;
  for (const auto& [x, y] : red) {
    bottom = std::max(bottom, y);
    top = std::min(top, y);
    if (std::abs(x - x_of(0.5)) < 6) {
      y_sum += y;
      count += 1;
    }
  }
  ASSERT_GT(count, 10);
  EXPECT_NEAR(y_sum / count, bottom - 0.25 * (bottom - top), 4);
}

TEST(PlotPicture, ALineEndsAtWhatIsNotFinite) {
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  Plot plot = dots({0, 1, 2, 3}, {1, kNothing, 1, 1});
  plot.series[0].line = true;
  plot.series[0].dot_px = 0;
  const std::vector<std::pair<int, int>> red = pixels_of(plot_picture(plot), kRed);
  ASSERT_FALSE(red.empty());
  const auto [left, right] = std::ranges::minmax_element(red);
  // From 2 to 3 alone: a third of the width.
  EXPECT_NEAR(right->first - left->first, 900 / 3.3, 40);
}

TEST(PlotPicture, CutsWhatLiesBeyondTheLimits) {
  Plot plot = dots({0, 1, 2}, {0, 1000, 1});
  plot.y_most = 2;
  EXPECT_FALSE(pixels_of(plot_picture(plot), kRed).empty());
  // The dots at 0 and 1 stand far apart, because 1000 does not stretch the axis.
  const std::vector<std::pair<int, int>> red = pixels_of(plot_picture(plot), kRed);
  const auto [top, bottom] =
      std::ranges::minmax_element(red, {}, [](const auto& p) { return p.second; });
  EXPECT_GT(bottom->second - top->second, 100);
}

TEST(PlotPicture, DrawsAxesOfNothing) {
  const dataset::Image<Rgb> empty = plot_picture(dots({}, {}));
  EXPECT_LT(pixels_of(empty, kWhite).size(), empty.pixels.size());
  const dataset::Image<Rgb> one = plot_picture(dots({3}, {3}));
  EXPECT_FALSE(pixels_of(one, kRed).empty());
  Plot tiny = dots({1, 2}, {std::numeric_limits<double>::infinity(), 2});
  tiny.width = 1;
  tiny.height = 1;
  EXPECT_EQ(plot_picture(tiny).width, 200);
}

TEST(DrawLabel, LettersDifferAndStayInside) {
  const std::string all =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789.,:-+=%()/_*^";
  std::vector<dataset::Image<Rgb>> seen;
  for (const char c : all) {
    dataset::Image<Rgb> picture(12, 18, kWhite);
    draw_label(picture, 0, 0, std::string(1, c), kRed);
    EXPECT_FALSE(pixels_of(picture, kRed).empty()) << c;
    EXPECT_TRUE(std::ranges::none_of(seen, [&](const dataset::Image<Rgb>& other) {
      return other.pixels == picture.pixels;
    })) << c;
    seen.push_back(std::move(picture));
  }
  dataset::Image<Rgb> small(3, 3, kWhite);
  draw_label(small, -5, -5, "cut", kRed);
  draw_label_upwards(small, 1, 1, "cut", kRed);
  EXPECT_EQ(label_width(""), 0);
  EXPECT_EQ(label_width("ab"), 11 * kLabelDot);
}

TEST(MapPicture, ShowsSignsAsColours) {
  dataset::Image<float> values(2, 1);
  values.pixels = {-3.0F, 3.0F};
  const dataset::Image<Rgb> picture = map_picture(values, "map", "mm");
  const int y = picture.height / 2;
  const Rgb left = picture.view().row(y)[100];
  const Rgb right = picture.view().row(y)[600];
  EXPECT_GT(left.blue, left.red);
  EXPECT_GT(right.red, right.blue);
  values.pixels = {0.0F, std::numeric_limits<float>::quiet_NaN()};
  const dataset::Image<Rgb> nothing = map_picture(values, "map", "mm");
  EXPECT_EQ(nothing.view().row(y)[100], kWhite);
  const Rgb unknown = nothing.view().row(y)[600];
  EXPECT_EQ(unknown.red, unknown.blue);
  EXPECT_NE(unknown, kWhite);
}

}  // namespace
}  // namespace stof::host
