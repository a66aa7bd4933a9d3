#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "dsp/fusion/drift/drift_monitor.h"

// Drift from what all patches have said.
namespace stof::dsp {

// Weighted sums over the frames of one patch: of the slopes J (the last of which is 1, so slope[4]
// is the sum of weights 1 / variance) and of the errors e.
struct DriftPatch {
  DriftVector slope{};
  double error = 0;
  double count = 0;

  bool known() const noexcept;  // says something; others are left out
  double weight() const noexcept { return slope[kDriftParameters - 1]; }
  void add(double error_px, const DriftVector& at, double variance) noexcept;
  void fade(double factor) noexcept;
};

// columns patches a row; trust and sorted are scratch, as long as patches.
struct DriftPatches {
  std::span<const DriftPatch> patches;
  int columns = 1;
  std::span<double> trust;
  std::span<double> sorted;
};

struct DriftSolution {
  DriftVector value{};
  DriftVector sigma{};
};

// The means of J and e of each patch count once, however many frames they come from: the least
// squares solution with weights that fall with the misfit (Huber's, then Tukey's), drawn to 0 by
// what is known before. sigma: jackknife over regions of a quarter of the picture's width, and over
// columns and rows of half as much, of which the largest counts; and an error that all patches of a
// region share.
// Nothing where the equations cannot be solved to a few digits, be it that parameters look alike
// to all patches or that a region outweighs the others beyond what doubles hold. A patch whose
// numbers are not finite is left out.
std::optional<DriftSolution> solve_drift(const DriftPatches& seen) noexcept;

}  // namespace stof::dsp
