#pragma once

#include "dsp/pmd/converter.h"
#include "host/evaluate/pmd/recordings/find.h"

// The converter where two surfaces meet inside a pixel, and where they do not.
namespace stof::host {

// Pixels of all frames. Shares are of the pixels that carry a distance.
struct EdgeCounts {
  long mixed = 0;  // mixed_pixels()
  long mixed_with_depth = 0;
  long mixed_flagged = 0;  // kPmdEdge
  long holding = 0;        // low <= r_min and r_max <= high
  long pure = 0;
  long pure_with_depth = 0;
  long pure_flagged = 0;
  long pure_flagged_beside = 0;  // of them: with a mixed pixel among the eight neighbours
  long pure_beside = 0;          // of pure_with_depth
  // Where maps of the middle distance are there: of pure_with_depth.
  long pure_holding = 0;             // low <= r_med <= high
  std::vector<double> pure_error_m;  // |reading - r_med|
  double worst_m = 0;                // most that an interval of a mixed pixel falls short by
  double worst_sigmas = 0;           // the same, in sigma of the pixel itself

  EdgeCounts& operator+=(const EdgeCounts& other);
};

struct EdgeRow {
  std::string name;
  double edge_m = 0;
  EdgeCounts counts;
};

// One row of the picture, for drawing. Metres; NaN where there is none.
struct EdgeSection {
  std::string name;
  int row = 0;
  std::vector<double> reading, least, most, low, high, nearest, farthest;  // least, most: of 3x3
  std::vector<std::uint8_t> mixed, flagged;
};

struct EdgeStudy {
  std::filesystem::path folder;
  std::vector<EdgeRow> rows;
  EdgeCounts all;
  // The first recording with most mixed pixels: the row with most of them, and pictures.
  EdgeSection section;
  dataset::Image<float> z_m;               // +inf = none
  dataset::Image<std::uint8_t> amplitude;  // its root, 255 the brightest
  dataset::Image<std::uint8_t> marks;      // 1 mixed + 2 flagged + 4 without a depth
};

// Counts one converted frame.
EdgeCounts count_edges(const dsp::PmdMaps& maps, const RangeMaps& truth,
                       const dataset::Image<std::uint8_t>& mixed);

// Recordings with r_min and r_max. One line where a recording or map cannot be read.
dataset::Loaded<EdgeStudy> study_edges(const PmdSet& set, const PmdSources& sources);

}  // namespace stof::host
