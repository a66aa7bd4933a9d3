#pragma once

#include <limits>
#include <string>
#include <vector>

#include "host/picture/png.h"

// Small diagrams for reports: lines and points over two axes.
namespace stof::host {

// Colours that differ for everybody (Okabe & Ito 2008).
inline constexpr Rgb kPlotBlue{0, 114, 178};
inline constexpr Rgb kPlotOrange{213, 94, 0};
inline constexpr Rgb kPlotGreen{0, 158, 115};
inline constexpr Rgb kPlotGrey{140, 140, 140};

struct PlotSeries {
  std::string name;  // in the legend; empty: not there
  std::vector<double> x;
  std::vector<double> y;  // as many; a point that is not finite interrupts the line
  Rgb colour = kPlotBlue;
  bool line = true;
  double dot_px = 0;  // diameter of a dot at every point; 0: none
};

struct Plot {
  std::string title;
  std::string x_label;
  std::string y_label;
  std::vector<PlotSeries> series;
  bool from_zero = false;  // the y axis begins at 0
  // What the y axis shows at most, whatever the series say; points outside are cut.
  double y_least = -std::numeric_limits<double>::infinity();
  double y_most = std::numeric_limits<double>::infinity();
  int width = 900;
  int height = 520;
};

// Axes with round numbers, a grid, the series and their legend, which stands above the grid.
// Without a finite point the axes go from 0 to 1. At least 200 x 150 px.
dataset::Image<Rgb> plot_picture(const Plot& plot);

// About `count` round numbers (1, 2 or 5 times a power of ten apart) that span low .. high from
// within; low < high.
std::vector<double> round_ticks(double low, double high, int count);

}  // namespace stof::host
