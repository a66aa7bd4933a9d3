#pragma once

#include <optional>
#include <vector>

#include "host/calibrate/rig/planes/plane_fit.h"

// What a rig makes of walls: depth of every pixel, against the plane that suits it best and against
// the wall's distance.
namespace stof::host {

struct WallJudgement {
  std::string name;
  double z_m = 0;
  double pixels = 0;    // that have a depth
  double dropped = 0;   // share of them further than 5 robust standard deviations from the plane:
                        // wrong matches, not counted in the spread
  double spread_m = 0;  // standard deviation of Z about the plane
  double bias_m = 0;    // of the plane on the left camera's axis, less z_m
  bool fitted = false;  // the constants were fitted to it
};

// None where the wall has fewer than 100 depths.
std::optional<WallJudgement> judge_wall(const Plane& plane, const PlaneSensor& sensor,
                                        const PlaneUnknowns& x);

// Of all pixels of the chosen walls together; NaN where there is none.
double pooled_spread_m(const std::vector<WallJudgement>& walls, bool fitted);

struct PlaneCalibration {
  GeneticResult genes;
  PlaneFit fit;
  double refined_rms_m = 0;  // depth_rms_m() of the fitted walls' cells, as genes.rms_m
  std::vector<WallJudgement> walls;
  // Of --chapter: its own objective, and Table 2 by it; offsets are columns right of the left
  // principal one.
  struct Chapter {
    GeneticResult genes;        // offset 0
    double table2_rms_m = 0;    // offset 0
    double best_offset_px = 0;  // where Table 2 is best
    double table2_best_rms_m = 0;
    double refined_rms_m = 0;    // the refined constants by this objective
    double elsewhere_rms_m = 0;  // the genes where they were not fitted: depth_rms_m()
  };
  std::optional<Chapter> chapter;
};

struct PlaneCalibrationOptions {
  PlanePriors priors;
  PlaneSensor sensor;
  GeneticOptions genes;
  int hold_out = 3;  // every so many walls judge and are not fitted to; 0: none
  bool chapter = false;
};

// One line where it does not converge.
dataset::Loaded<PlaneCalibration> calibrate_planes(const std::vector<Plane>& planes,
                                                   const PlaneCalibrationOptions& options);

// The rig of these constants, for pictures of this size; complete().
dsp::StereoRig rig_of(const PlaneUnknowns& x, const PlaneSensor& sensor, int width, int height);

}  // namespace stof::host
