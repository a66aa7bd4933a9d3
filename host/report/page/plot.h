#pragma once

#include <limits>
#include <string>
#include <vector>

#include "host/report/page/page.h"

// Diagrams as inline SVG, drawn by the browser: lines and points over two axes.
namespace stof::host {

// Colours that differ for everybody (Okabe & Ito 2008), on light and on dark paper.
inline constexpr Rgb kPlotBlue{0, 114, 178};
inline constexpr Rgb kPlotOrange{213, 94, 0};
inline constexpr Rgb kPlotGreen{0, 158, 115};
inline constexpr Rgb kPlotGrey{140, 140, 140};

struct PlotSeries {
  std::string name;  // in the legend; empty: not there
  Rgb colour = kPlotBlue;
  bool line = true;
  double dot_px = 0;  // diameter of a dot at every point; 0: none
  std::vector<double> x{};
  std::vector<double> y{};  // as many; a point that is not finite interrupts the line

  void add(double x_value, double y_value) {
    x.push_back(x_value);
    y.push_back(y_value);
  }
};

struct Plot {
  std::string title;
  std::string x_label;  // with the unit
  std::string y_label;
  std::vector<PlotSeries> series;
  bool from_zero = false;  // the y axis begins at 0
  // The most that the y axis shows, whatever the series have; points outside are cut.
  double y_least = -std::numeric_limits<double>::infinity();
  double y_most = std::numeric_limits<double>::infinity();
};

// Axes with round numbers, a grid and the series; the legend stands below.
// Without a finite point the axes go from 0 to 1.
Figure plot_figure(const Plot& plot, std::string caption);

}  // namespace stof::host
