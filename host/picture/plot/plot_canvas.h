#pragma once

#include <array>
#include <string>

#include "host/picture/png.h"

// What plots are drawn on. For host/picture/plot*.cpp.
namespace stof::host {

inline constexpr Rgb kPlotInk{40, 40, 40};
inline constexpr int kPlotMargin = 14;
inline constexpr int kPlotGap = 8;

// Pixels that may be touched, all four edges included.
struct Area {
  int left = 0;
  int top = 0;
  int right = 0;
  int bottom = 0;
};

class Canvas {
 public:
  Canvas(int width, int height) : picture_(width, height, Rgb{255, 255, 255}) {}

  dataset::Image<Rgb>& picture() { return picture_; }
  // What lies outside of the picture is cut.
  void box(int left, int top, int right, int bottom, Rgb colour);  // right and bottom outside
  // A line with soft edges; a dot is a line without length.
  void stroke(const Area& area, std::array<double, 2> a, std::array<double, 2> b, double width,
              Rgb colour);

 private:
  void blend(int x, int y, Rgb colour, double share);
  dataset::Image<Rgb> picture_;
};

Rgb blended(Rgb below, Rgb above, double share);

// With as many decimals as numbers `step` apart need.
std::string number_text(double value, double step);

}  // namespace stof::host
