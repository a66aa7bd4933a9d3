#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/calib/calibration.h"
#include "dsp/calib/pmd/ray_table.h"
#include "dsp/fusion/drift/drift_monitor.h"
#include "dsp/pmd/converter.h"

// Planes that the PMD camera sees, as they ought to appear in the left picture.
namespace stof::dsp {

// Expected disparity d + gx (x - u) + gy (y - v) of the left pixels within low .. high. Pixels.
struct ExpectedPlane {
  double u = 0;  // the mean of its readings
  double v = 0;
  double d = 0;
  double gx = 0;
  double gy = 0;
  double u_low = 0;
  double u_high = 0;
  double v_low = 0;
  double v_high = 0;
  double variance = 0;  // of d, from the noise of the readings
  DriftVector slope{};  // J of drift_monitor.h
};

class PlaneReader {
 public:
  PlaneReader() noexcept = default;
  PlaneReader(const Calibration& calibration, Arena& arena) noexcept;

  // Side of a patch in PMD pixels: some 24 px of the left picture, 4 .. 16.
  int side() const noexcept { return side_; }

  // The patch whose upper left pixel is (x, y), inside the picture. Where something moved, readings
  // count by their noise, and a quarter of them may be missing. Nothing where others are, where
  // they do not lie on one plane, or where the plane is not before the left camera.
  std::optional<ExpectedPlane> read(int x, int y, const PmdMaps& maps) const noexcept;

 private:
  using Point = std::array<double, 3>;
  // Where a point lies in the left picture, and its disparity.
  struct Place {
    double u = 0;
    double v = 0;
    double d = 0;
  };
  struct Readings;

  std::optional<Place> place(const Point& point) const noexcept;
  std::optional<Readings> collect(int x, int y, const PmdMaps& maps) const noexcept;
  bool fit(const Readings& readings, ExpectedPlane& plane) const noexcept;
  bool add_slope(const Point& middle, ExpectedPlane& plane) const noexcept;

  StereoRig rig_;
  double tan_left_ = 0;  // of the axes of a converging pair
  double tan_right_ = 0;
  Point origin_{};  // the PMD camera in the axes of the left one
  int width_ = 0;
  int side_ = 4;
  RayTable rays_;
};

}  // namespace stof::dsp
