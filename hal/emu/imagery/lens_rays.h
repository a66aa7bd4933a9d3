#pragma once

#include <span>
#include <vector>

#include "dsp/calib/pinhole.h"
#include "hal/emu/scenes/vec3.h"
#include "hal/emu/scenes/viewpoint.h"

// How a lens bends what it shows. The model is dsp::Pinhole's (Brown 1971), with the coefficients
// and the meaning that OpenCV's module calib3d gives to its distCoeffs k1 k2 p1 p2 k3 ("Camera
// Calibration and 3D Reconstruction", detailed description). The emulator computes it by itself:
// what it renders judges dsp/calib.
namespace stof::hal::emu {

struct PicturePoint {
  double u = 0;
  double v = 0;
};

// Where the lens shows the direction (x, y, 1).
PicturePoint project(const dsp::Pinhole& lens, double x, double y) noexcept;

// The direction (x, y, 1) that the lens shows at (u, v): the inverse of project(), to 1e-12 on the
// normalised plane (Newton's method) where the lens does not fold there.
Vec3 undistorted_ray(const dsp::Pinhole& lens, double u, double v) noexcept;

// Every place of the picture, two pixels beyond its border included, shows one direction, which
// project() brings back there to within 1e-9 px, and the lens does not fold on the way out to it.
bool shows_each_place_once(const dsp::Pinhole& lens) noexcept;

// The directions that the pixels of a picture show. Without distortion they are exact at every
// place; with it at the centres of pixels, to 1e-12. Within a pixel they are linear then, which is
// wrong by less than 1e-3 px for lenses that bend by less than a fifth (k1 = -0.3, 60 degrees).
class LensRays {
 public:
  explicit LensRays(const dsp::Pinhole& lens);

  const dsp::Pinhole& lens() const noexcept { return lens_; }
  // The direction (x, y, 1) at a place of the picture.
  Vec3 at(double u, double v) const noexcept {
    return centres_.empty() ? Vec3{(u - lens_.cx) / lens_.fx, (v - lens_.cy) / lens_.fy, 1}
                            : near(u, v);
  }
  // What pixel (x, y) sees.
  Viewpoint::Window window(int x, int y) const noexcept;
  // Of all pixels, row by row; empty without distortion.
  std::span<const Vec3> centres() const noexcept { return centres_; }

 private:
  Vec3 near(double u, double v) const noexcept;
  Vec3 beside(int x, int y, double du, double dv) const noexcept;

  dsp::Pinhole lens_;
  std::vector<Vec3> centres_;
};

}  // namespace stof::hal::emu
