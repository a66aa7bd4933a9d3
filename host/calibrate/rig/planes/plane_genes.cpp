#include <chrono>
#include <cmath>

#include <pagmo/algorithm.hpp>
#include <pagmo/algorithms/sga.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>

#include "host/calibrate/rig/planes/plane_fit.h"

namespace stof::host {
namespace {

using pagmo::vector_double;

constexpr double kSpread = 0.15;    // of baseline and focal length
constexpr double kWidestRad = 0.2;  // of alpha - beta, and of their mean
constexpr double kFocalRatio = 0.05;
// A wall that is nowhere is as wrong as one this many times too far.
constexpr double kMostRatio = 3;

double bounded(double z, double wall) {
  const bool before = std::isfinite(z) && z > 0 && z < kMostRatio * wall;
  return before ? z - wall : (kMostRatio - 1) * wall;
}

struct ColumnPair {
  double left_m;
  double right_m;
  double z_m;
};

double mean_square(const std::vector<ColumnPair>& columns, const PlaneUnknowns& x) {
  const double right_yaw = std::tan(x[1]);
  const double left_yaw = std::tan(x[2]);
  double sum = 0;
  for (const ColumnPair& c : columns) {
    const double parallax =
        tangent_of(right_yaw, -c.right_m / x[3]) - tangent_of(left_yaw, -c.left_m / x[4]);
    const double error = bounded(x[0] / parallax, c.z_m);
    sum += error * error;
  }
  return sum / static_cast<double>(columns.size());
}

// The constants as genes that disparities tell apart: b F, alpha - beta, the mean of both, the mean
// focal length F, f1 / f2. Of the constants themselves none can change alone without spoiling what
// the others have reached.
PlaneUnknowns from_genes(const vector_double& genes) {
  const double focal = genes[3];
  const double f2 = 2 * focal / (1 + genes[4]);
  return {genes[0] / focal, genes[2] + genes[1] / 2, genes[2] - genes[1] / 2, genes[4] * f2, f2};
}

// pagmo copies problems: this one borrows.
struct ColumnProblem {
  const std::vector<ColumnPair>* columns = nullptr;
  PlaneUnknowns low{};  // of the genes
  PlaneUnknowns high{};

  vector_double fitness(const vector_double& genes) const {
    return {mean_square(*columns, from_genes(genes))};
  }
  std::pair<vector_double, vector_double> get_bounds() const {
    return {{low.begin(), low.end()}, {high.begin(), high.end()}};
  }
};

std::vector<ColumnPair> columns_of(const std::vector<Plane>& planes, const PlaneSensor& sensor) {
  std::vector<ColumnPair> columns;
  for (const Plane& plane : planes) {
    for (const PlaneCell& cell : plane.cells) {
      columns.push_back({sensor.left_m(cell), sensor.right_m(cell), plane.z_m});
    }
  }
  return columns;
}

// One pair of columns a wall: its mean disparity.
std::vector<ColumnPair> averages_of(const std::vector<Plane>& planes, const PlaneSensor& sensor,
                                    double offset_px) {
  std::vector<ColumnPair> columns;
  for (const Plane& plane : planes) {
    double disparity_m = 0;
    for (const PlaneCell& cell : plane.cells) {
      disparity_m += sensor.left_m(cell) - sensor.right_m(cell);
    }
    disparity_m /= static_cast<double>(plane.cells.size());
    const double left = offset_px * sensor.pixel_m;
    columns.push_back({left, left - disparity_m, plane.z_m});
  }
  return columns;
}

GeneticResult evolve(const ColumnProblem& over, const GeneticOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  constexpr double kCrossover = 0.9;
  constexpr double kCrossoverIndex = 10;
  constexpr double kMutation = 0.2;
  constexpr double kMutationIndex = 40;
  // Mutations become finer from round to round: the constants hang together, and large steps in one
  // of them alone hit nothing in the end.
  constexpr unsigned kRounds = 4;
  pagmo::population population{pagmo::problem{over}, options.population, options.seed};
  for (unsigned round = 0; round < kRounds; ++round) {
    const pagmo::algorithm genes{pagmo::sga(options.generations / kRounds, kCrossover,
                                            kCrossoverIndex, kMutation,
                                            std::min(100.0, kMutationIndex * (1 + round)), 2, "sbx",
                                            "polynomial", "tournament", options.seed + round)};
    population = genes.evolve(population);
  }
  GeneticResult result;
  result.x = from_genes(population.champion_x());
  result.rms_m = std::sqrt(population.champion_f()[0]);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

}  // namespace

double depth_rms_m(const std::vector<Plane>& planes, const PlaneSensor& sensor,
                   const PlaneUnknowns& x) {
  return std::sqrt(mean_square(columns_of(planes, sensor), x));
}

double chapter_rms_m(const std::vector<Plane>& planes, const PlaneSensor& sensor,
                     const PlaneUnknowns& x, double offset_px) {
  return std::sqrt(mean_square(averages_of(planes, sensor, offset_px), x));
}

GeneticResult evolve(const std::vector<Plane>& planes, const PlaneSensor& sensor,
                     const PlanePriors& priors, const GeneticOptions& options) {
  const std::vector<ColumnPair> columns = columns_of(planes, sensor);
  const auto range = [](double value, double share) { return value * (1 + share); };
  const double product = priors.baseline_m * priors.focal_m;
  return evolve(ColumnProblem{.columns = &columns,
                              .low = {range(product, -2 * kSpread), -kWidestRad, -kWidestRad,
                                      range(priors.focal_m, -kSpread), 1 - kFocalRatio},
                              .high = {range(product, 2 * kSpread), kWidestRad, kWidestRad,
                                       range(priors.focal_m, kSpread), 1 + kFocalRatio}},
                options);
}

GeneticResult evolve_chapter(const std::vector<Plane>& planes, const PlaneSensor& sensor,
                             double offset_px, const GeneticOptions& options) {
  const std::vector<ColumnPair> columns = averages_of(planes, sensor, offset_px);
  return evolve(ColumnProblem{.columns = &columns,
                              .low = {1e-3, -0.1, 0.0, 0.5, 0.9},
                              .high = {3e-3, 0.1, 0.5, 1.0, 1.1}},
                options);
}

}  // namespace stof::host
