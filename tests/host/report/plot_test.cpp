#include "host/report/page/plot.h"

#include <algorithm>
#include <regex>

#include <gtest/gtest.h>

namespace stof::host {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr Rgb kRed{255, 0, 0};

Plot dots(std::vector<double> x, std::vector<double> y) {
  return {.title = "t <",
          .x_label = "x, m",
          .y_label = "y",
          .series = {{.name = "red",
                      .colour = kRed,
                      .line = false,
                      .dot_px = 7,
                      .x = std::move(x),
                      .y = std::move(y)}}};
}

// The path of the red series.
std::string red_path(const Plot& plot) {
  const std::string svg = plot_figure(plot, "").picture;
  std::smatch found;
  std::regex_search(svg, found, std::regex(R"re(<path d="([^"]*)" stroke="#ff0000")re"));
  return found.empty() ? "" : found[1].str();
}

struct Place {
  char step;  // M: goes there, L: draws a line there
  double x;
  double y;
};
std::vector<Place> places(const Plot& plot) {
  const std::string path = red_path(plot);
  std::vector<Place> all;
  const std::regex step(R"(([ML])([-0-9.]+) ([-0-9.]+))");
  for (std::sregex_iterator at(path.begin(), path.end(), step), end; at != end; ++at) {
    all.push_back({(*at)[1].str().front(), std::stod((*at)[2]), std::stod((*at)[3])});
  }
  return all;
}

TEST(PlotFigure, PutsDotsWhereNumbersSay) {
  const std::vector<Place> at = places(dots({0, 1, 2}, {0, 1, 4}));
  ASSERT_EQ(at.size(), 3U);
  EXPECT_GT(at[2].x - at[0].x, 350);
  EXPECT_GT(at[0].y - at[2].y, 180);
  EXPECT_NEAR(at[1].x, (at[0].x + at[2].x) / 2, 0.2);
  EXPECT_NEAR(at[1].y, at[0].y + 0.25 * (at[2].y - at[0].y), 0.2);
}

TEST(PlotFigure, ALineEndsAtWhatIsNotFinite) {
  Plot plot = dots({0, 1, 2, 3}, {1, kNothing, 1, 1});
  plot.series[0].line = true;
  plot.series[0].dot_px = 0;
  std::string steps;
  for (const Place& place : places(plot)) {
    steps += place.step;
  }
  EXPECT_EQ(steps, "MML");  // from 2 to 3 alone
}

TEST(PlotFigure, CutsWhatLiesBeyondTheLimits) {
  Plot plot = dots({0, 1, 2}, {0, 1000, 1});
  plot.y_most = 2;
  // The dots at 0 and 1 stand far apart, because 1000 does not stretch the axis.
  const std::vector<Place> at = places(plot);
  ASSERT_EQ(at.size(), 2U);
  EXPECT_GT(at[0].y - at[1].y, 100);
}

TEST(PlotFigure, DrawsAxesOfNothing) {
  const Figure empty = plot_figure(dots({}, {}), "");
  EXPECT_NE(empty.picture.find("class=\"axes\""), std::string::npos);
  EXPECT_NE(empty.picture.find(">0.4<"), std::string::npos);
  EXPECT_EQ(places(dots({3}, {3})).size(), 1U);
  EXPECT_EQ(places(dots({1, 2}, {std::numeric_limits<double>::infinity(), 2})).size(), 1U);
  EXPECT_EQ(empty.picture.find("nan"), std::string::npos);
}

TEST(PlotFigure, NamesAxesAndSeries) {
  const Figure figure = plot_figure(dots({0, 5}, {0, 1}), "what it shows");
  EXPECT_NE(figure.picture.find(">x, m</text>"), std::string::npos);
  EXPECT_NE(figure.picture.find("aria-label=\"t &lt;\""), std::string::npos);
  EXPECT_NE(figure.legend.find("red"), std::string::npos);
  EXPECT_NE(figure.legend.find("#ff0000"), std::string::npos);
  EXPECT_EQ(figure.title, "t <");
  EXPECT_EQ(figure.caption, "what it shows");
}

}  // namespace
}  // namespace stof::host
