#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dataset/dataset.h"

// A flat, richly textured wall at known distances, facing the rig (parallel to its baseline),
// matched by the chapter's method: sums of squared differences, winner takes all.
namespace stof::host {

struct PlaneOptions {
  int min_disparity = -64;
  int disparities = 256;
  int block = 17;       // px
  double middle = 0.6;  // of width and height: what is looked at. Rows of converging axes drift
                        // apart towards the corners
  bool subpixel = true;
  int threads = 1;
};

// A patch of the wall: columns and row are means over its matches.
struct PlaneCell {
  double left = 0;   // column in the left picture, px
  double right = 0;  // column in the right picture
  double row = 0;
};

struct Plane {
  std::string name;
  double z_m = 0;  // of the wall, from the left camera along the perpendicular of the baseline
  dataset::Image<float> disparity;  // NaN: none, and beside the middle
  std::vector<PlaneCell> cells;     // those that are full of matches that agree
  double matched = 0;               // share of the middle that has a disparity
};

// A folder with left.pgm, right.pgm, and in meta.txt a line `plane_z_m N`. One line where it cannot
// be read or matched.
dataset::Loaded<Plane> read_plane(const std::filesystem::path& dir, const PlaneOptions& options);
// What its meta.txt says, metres.
dataset::Loaded<double> plane_distance(const std::filesystem::path& dir);
// Such a meta.txt.
std::expected<void, dataset::Problem> write_plane_distance(const std::filesystem::path& dir,
                                                           double z_m);

// The folders in DIR that have left.pgm, right.pgm, and in meta.txt a line `plane_z_m N`, nearest
// first. One line where there are fewer than three such distances, pictures differ in size, or one
// cannot be matched.
dataset::Loaded<std::vector<Plane>> read_planes(const std::filesystem::path& dir,
                                                const PlaneOptions& options);

// The patches of a map of disparities.
std::vector<PlaneCell> cells_of(const dataset::Image<float>& disparity);

}  // namespace stof::host
