#pragma once

#include <Eigen/Dense>

#include "host/calibrate/fit/pmd_fit.h"

// The linear equations of one observation. For pmd_fit.cpp.
namespace stof::host {

enum Unknown : int {
  kOffset = 0,
  kScale = 1,
  kStrayI = 2,
  kStrayQ = 3,
  kEmitterX = 4,
  kEmitterY = 5,
  kWallTurnX = 6,
  kWallTurnY = 7,
  kWallShift = 8,
  kFirstHarmonic = 9,  // cosine and sine of each
  kUnknowns = kFirstHarmonic + 2 * kHarmonics
};
using Column = Eigen::Matrix<double, kUnknowns, 1>;
using Square = Eigen::Matrix<double, kUnknowns, kUnknowns>;

// Residual of one observation and how it depends on everything.
struct Row {
  double residual = 0;    // standard deviations
  double weight = 0;      // Huber's
  double by_pattern = 0;  // d residual / d pattern of the pixel
  Column by = Column::Zero();
};

// Residuals beyond this many standard deviations count linearly (Huber).
inline constexpr double kHuber = 3;

bool is_active(const FitParts& parts, int unknown) noexcept;

// Observation::sigma must be set.
Row row_of(const WallData& data, const FitParts& parts, const PmdModel& model,
           const Observation& observation);

// x, y of one light, or half the spread of two.
void move_emitters(PmdModel& model, double x, double y);

// Weak: they only decide where walls do not. 1 / variance around a scale of 1, harmonics of 0.
double prior_of(int unknown) noexcept;

}  // namespace stof::host
