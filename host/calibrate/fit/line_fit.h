#pragma once

#include <optional>
#include <vector>

#include "host/calibrate/fit/pmd_fit.h"

// The straight line alone: z = a d + b, d from the raw phase (Kuhnert & Stommel 2006, eq. 14).
namespace stof::host {

struct LineFit {
  double a = 1;
  double b_m = 0;
  // The same in the chapter's units: z in cm = slope phi + intercept, phi in counts of 138.7 a
  // turn, falling with distance.
  double slope_cm = 0;
  double intercept_cm = 0;
  double worst_relative = 0;  // |z error| / z of the walls it was fitted to
  double from_m = 0;          // the nearest of them
};

// Nearer than this the chapter's camera is not used.
inline constexpr double kLineFromM = 1.5;

// Mean Z of the middle of the picture by this line, less the wall's; NaN where no pixel is usable.
double line_error(const LineFit& line, const WallData& data, const PmdModel& model,
                  const Wall& wall);

// Least squares over the means of the middle of each wall of 1.5 m and more, or of all where these
// are fewer than three. `model` knows the sign of the phase and the offset, which says how many
// turns a phase has; the rest of it is not used. None from fewer than two distances.
std::optional<LineFit> fit_line(const WallData& data, const PmdModel& model);

}  // namespace stof::host
