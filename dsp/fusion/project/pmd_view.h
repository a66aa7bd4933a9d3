#pragma once

#include <array>

#include "dsp/base/fixed.h"
#include "dsp/calib/calibration.h"

namespace stof::dsp {

// Where the PMD camera sees a point of the left view: the way back of `project`.
class PmdView {
 public:
  // A place in the PMD picture and the distance along its ray, quarter mm. Not seen: column -1.
  struct Place {
    int column = -1;
    int row = -1;
    float distance = 0;
    bool seen() const noexcept { return column >= 0; }
  };

  PmdView() = default;
  // complete() calibration with a PMD lens.
  explicit PmdView(const Calibration& calibration) noexcept;

  // Of pixel (x, y) of the left view at depth Z, quarter mm: X_p = R^T (X_s - T), then the lens
  // with its distortion (dsp/calib/pinhole.h), to the nearest pixel. By IEEE single operations.
  Place of(int x, int y, float depth) const noexcept;

 private:
  struct Lens {
    float fx = 1, fy = 1, cx = 0, cy = 0, k1 = 0, k2 = 0, k3 = 0, p1 = 0, p2 = 0;
  };
  // The ray of left pixel (x, y) at Z = 1 in PMD axes: origin + x along + y down.
  std::array<float, 3> origin_{};
  std::array<float, 3> along_{};
  std::array<float, 3> down_{};
  std::array<float, 3> shift_{};  // R^T T, quarter mm
  Lens lens_;
  float widest_ = 0;  // of x^2 + y^2 on the normalised plane: beyond, distortion folds over
  int width_ = 0;
  int height_ = 0;
};

}  // namespace stof::dsp
