#pragma once

#include <cstdint>
#include <expected>
#include <filesystem>
#include <optional>
#include <string>

#include "dataset/image.h"
#include "dsp/calib/calibration.h"

namespace stof::dataset {

// The surface that a pixel of a scene above a floor shows. Values are those of surfaces.pgm.
enum class Surface : std::uint8_t {
  kOther = 0,
  kFloor = 1,
  kLowerFloor = 2,  // below the floor, from an edge on
  kBox = 3,
  kGlass = 4,
  kWall = 5,
};
inline constexpr int kSurfaces = 6;

// A level floor, the left camera above it, and what else is seen.
struct FloorTruth {
  double height_m = 0;      // of the left camera above the floor
  double tilt_degrees = 0;  // by which it looks down; it is level sideways
  Image<Surface> surface;   // of the left view
};

// A stereo scene. left and right have equal size.
struct StereoScene {
  std::string name;  // the folder's name
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;
  int ndisp = 64;                              // search range to use, from meta.txt
  std::optional<Image<float>> truth;           // disparity in px of the left view, +inf = unknown
  std::optional<Image<std::uint8_t>> visible;  // not 0 = known and seen by both cameras
  // Parallel cameras, from meta.txt's f_px, baseline_m and doff_px (0 where absent); the principal
  // point is taken for the middle of the picture.
  std::optional<dsp::StereoRig> rig;
  std::optional<FloorTruth> floor;  // from surfaces.pgm and meta.txt
  // The pair looks at a plane perpendicular to its axes, so far away: measured, as a tape does.
  std::optional<double> plane_z_m;
};

// Reads DIR. left.pgm, right.pgm and meta.txt must be there; gt_left.pgm, nonocc.pgm and
// surfaces.pgm may be.
Loaded<StereoScene> read_stereo_scene(const std::filesystem::path& dir);

// Writes the files of a scene into a folder that exists; truth in steps of 1/256 px, up to 255 px.
std::expected<void, Problem> write_stereo_scene(const std::filesystem::path& dir,
                                                const StereoScene& scene);

}  // namespace stof::dataset
