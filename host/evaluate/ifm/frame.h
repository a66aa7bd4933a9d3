#pragma once

#include <optional>

#include "dataset/dataset.h"

// One frame of an ifm O3R camera: its radial distances through our rays, against its own cloud.
namespace stof::host {

struct FrameCloud {
  dataset::Image<float> x, y, z;  // metres; NaN where the camera has no distance
};

// The length of the difference of two clouds, per pixel, metres.
struct CloudDifference {
  double largest_m = 0;
  double median_m = 0;
  long pixels = 0;
};

// A member for each figure that is printed.
struct FrameStudy {
  std::filesystem::path folder;
  int width = 0;
  int height = 0;
  long valid = 0;       // pixels with a distance and, by the confidence, not invalid
  bool buffer = false;  // O3RBuffer.data was there
  bool has_cartesian = false;
  bool same_distances = true;             // buffer and radial_distance.pgm
  std::optional<CloudDifference> camera;  // against the camera's Cartesian images
  CloudDifference exact;                  // against the same intrinsics in double precision
  // Against the camera's own description of the way back (pixel to ray), where the buffer has it.
  std::optional<CloudDifference> way_back;
  // Spearman's, of 1 / amplitude with the camera's noise: amplitude of the pixel's own exposure
  // where the buffer tells exposures apart, and as the amplitude image gives it.
  bool knows_exposures = false;
  double rank_correlation = 0;
  double rank_correlation_as_given = 0;
  double median_noise_m = 0;
  FrameCloud cloud;
  dataset::Image<float> amplitude;  // camera units
};

// The files of frame_file.h. One line for what is bad.
dataset::Loaded<FrameStudy> study_frame(const std::filesystem::path& folder);

}  // namespace stof::host
