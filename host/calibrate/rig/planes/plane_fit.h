#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "host/calibrate/rig/planes/converging_model.h"
#include "host/calibrate/rig/planes/plane_disparities.h"

// From disparities of walls at known distances to the five constants of a rig whose axes converge.
namespace stof::host {

// What is known beside the pictures. Disparities alone tell b F cos^2(alpha) and alpha - beta; the
// rest of the five constants is as good as these.
struct PlanePriors {
  double baseline_m = 0.2;  // by the tape
  double baseline_sigma_m = 0.002;
  double focal_m = 0.0085;             // what stands on the lens
  double focal_sigma = 0.02;           // of it
  double focal_difference = 0.005;     // of f1 to f2, sigma, share
  double pointing_sigma_rad = 0.0175;  // of (alpha + beta) / 2: by the eye, 1 degree
  double distance_sigma_m = 0.001;     // of each wall
  double tilt_sigma_rad = 0.005;       // of each wall, about either axis
};

// How columns become metres on the sensor.
struct PlaneSensor {
  double pixel_m = 5.6e-6;
  double cx_left = 0;  // principal columns and row, px
  double cx_right = 0;
  double cy = 0;
  double left_m(const PlaneCell& cell) const { return (cell.left - cx_left) * pixel_m; }
  double right_m(const PlaneCell& cell) const { return (cell.right - cx_right) * pixel_m; }
};

// Root mean square of Z less the walls' distances, m; infinite where a cell lies nowhere.
double depth_rms_m(const std::vector<Plane>& planes, const PlaneSensor& sensor,
                   const PlaneUnknowns& x);

// The same of the chapter's objective: one disparity a wall, the mean over all of its cells, as if
// both cameras saw it at column `offset_px` right of the left principal column.
double chapter_rms_m(const std::vector<Plane>& planes, const PlaneSensor& sensor,
                     const PlaneUnknowns& x, double offset_px);

struct GeneticOptions {
  unsigned generations = 2000;
  unsigned population = 120;
  unsigned seed = 1;
};
struct GeneticResult {
  PlaneUnknowns x{};
  double rms_m = 0;  // of what was minimised
  double seconds = 0;
};
// A genetic algorithm (pagmo's sga: tournaments, simulated binary crossover, polynomial mutation)
// over depth_rms_m(); within 30 percent of baseline times focal length, 15 percent of the latter, 5
// percent between both, and 0.2 rad.
GeneticResult evolve(const std::vector<Plane>& planes, const PlaneSensor& sensor,
                     const PlanePriors& priors, const GeneticOptions& options);
// The chapter's: over chapter_rms_m(), no prior, each constant in a range that holds Table 2.
GeneticResult evolve_chapter(const std::vector<Plane>& planes, const PlaneSensor& sensor,
                             double offset_px, const GeneticOptions& options);

struct PlaneFit {
  PlaneUnknowns x{};
  Eigen::Matrix<double, int{kPlaneUnknowns}, int{kPlaneUnknowns}> covariance;
  std::array<double, kPlaneUnknowns> from_prior{};  // sigma without any picture
  double constant_sigma = 0;                        // of triangulation_constant()
  double difference_sigma = 0;                      // of alpha - beta, rad
  double cell_sigma_px = 0;                         // of a cell's disparity, from the residuals
  double sigma(std::size_t i) const {
    const auto k = static_cast<Eigen::Index>(i);
    return std::sqrt(covariance(k, k));
  }
};
// Levenberg-Marquardt (Ceres) from `start`: what disparities and priors leave, each in its standard
// deviations; walls may be nearer, farther and tilted as far as the priors allow. None where it
// does not converge.
std::optional<PlaneFit> refine(const std::vector<Plane>& planes, const PlaneSensor& sensor,
                               const PlanePriors& priors, const PlaneUnknowns& start);

}  // namespace stof::host
