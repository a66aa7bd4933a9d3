#pragma once

#include <functional>

#include "dataset/image.h"
#include "host/calibrate/rig/target/board.h"
#include "host/calibrate/rig/target/lens_model.h"
#include "tests/host/calibrate/rig/gaussian.h"

// Pictures of one plane, through lenses with distortion.
namespace stof::host::test {

// Grey of a place on the plane, in its own axes, metres.
using Texture = std::function<double(double x, double y)>;

// A chessboard with a square of white around it, grey elsewhere. The axes are those of Board.
Texture chessboard(const Board& board);
// A board with markers as `stof calib target` prints it, grey around the sheet. turned: each tag
// stands on its head.
Texture print_of(const Board& board, bool turned = false);
// Blotches of two sizes, the same everywhere for the same seed.
Texture blotches(std::uint64_t seed);

// Renders through one lens, several planes after another.
class PlaneCamera {
 public:
  // samples: rays a side of a pixel. 3 tell the place of an edge to some hundredths of a pixel.
  explicit PlaneCamera(const dsp::Pinhole& lens, int samples = 3);

  // Grey 100 where the ray misses the plane. smear_px: moved so far along rows while the picture
  // was exposed.
  dataset::Image<std::uint8_t> picture(const PoseUnknowns& plane_to_camera, const Texture& texture,
                                       double noise, Gaussian& random, int smear_px = 0) const;
  const dsp::Pinhole& lens() const { return lens_; }

 private:
  dsp::Pinhole lens_;
  int samples_;
  std::vector<std::array<float, 2>> rays_;  // x / z, y / z of each sample
};

// A plane's pose seen from a camera that stands elsewhere.
PoseUnknowns seen_from(const PoseUnknowns& first_to_second, const PoseUnknowns& plane_to_first);

}  // namespace stof::host::test
