#pragma once

#include <array>

#include "dsp/calib/calibration.h"

namespace stof::dsp {

// How the pictures of a RawPair become rows that correspond (after Bouguet): the rotation between
// the cameras is shared out in halves, then both are turned together until the new x axis runs
// along the baseline. Both rectified cameras have the pictures' size, the mean focal length and one
// principal row. Their principal columns are equal (infinity has disparity 0), unless the axes
// converge or diverge so much that this would move the pictures by more than an eighth of their
// width against what the cameras see; what is more than that goes into doff.
struct Rectification {
  std::array<double, 9> left_turn{};  // X_rectified = turn X_camera, row-major
  std::array<double, 9> right_turn{};
  Pinhole left;  // rectified, without distortion
  Pinhole right;
  double baseline_m = 0;
};

// problem_of(pair) must be empty.
Rectification rectify(const RawPair& pair) noexcept;

// Empty, or what is wrong with the pair, for a message: numbers that are not usable, a size below
// 2x2, a right camera that does not stand to the right of the left one (within 45 degrees), a turn
// of more than 60 degrees, rectified pictures of which less than a quarter shows something.
const char* problem_of(const RawPair& pair) noexcept;

// Where a pixel of a rectified picture lies in the raw one, the whole distortion of Pinhole
// applied.
class SourceMap {
 public:
  struct Place {
    double u = 0;  // nearest place between the centres of the outermost pixels
    double v = 0;
    bool inside = false;  // the ray meets the picture there, and does not lie behind the camera or
                          // beyond the radius at which the distortion folds over
  };

  SourceMap(const Pinhole& raw, const std::array<double, 9>& turn,
            const Pinhole& rectified) noexcept;
  Place at(double u, double v) const noexcept;
  // The same before u and v are brought into the picture: what varies smoothly beyond its border
  // too. `inside` tells nothing of the border.
  Place unbounded(double u, double v) const noexcept;

  const Pinhole& raw() const noexcept { return raw_; }
  const Pinhole& rectified() const noexcept { return rectified_; }

 private:
  Pinhole raw_;
  Pinhole rectified_;
  std::array<double, 9> turn_;
  double fold_ = 0;  // square of that radius
};

}  // namespace stof::dsp
