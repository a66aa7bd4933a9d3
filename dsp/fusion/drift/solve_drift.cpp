#include "dsp/fusion/drift/solve_drift.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "dsp/base/index.h"

namespace stof::dsp {
namespace {

constexpr std::size_t kN = kDriftParameters;
using Matrix = std::array<double, kN * kN>;

// Where a number was chosen, the range over which it was varied stands beside it: see
// disparity_shift.cpp.

// What is known before, as standard deviations: a mount turns by a degree and moves by 10 cm at
// most, and a pair that was calibrated keeps its disparities. Radians, metres, pixels.
constexpr DriftVector kPrior{0.02, 0.02, 0.02, 0.1, 0.05};

// What no number of frames improves: an error of each patch, px (its plane is not quite one), and
// the share of a frame's variance that the next frame repeats, as its texture does (chosen: 0.005
// to 0.06; 0 to 0.5).
constexpr double kPatchNoisePx = 0.02;
constexpr double kLasting = 0.15;
// An error that all patches of a region share, px: distortion that the calibration left (chosen: 0
// to 0.05; it adds to sigma alone, and with 0.05 hides a turn of 0.2 degrees).
constexpr double kRegionNoisePx = 0.017;
// Rounds: one with all weights alike, eight with Huber's weights, eight with Tukey's. Of 40 the
// result is the same to 0.001 degrees.
constexpr int kRounds = 17;
// In standard deviations. Huber's usual bound is 1.345, Tukey's 4.685 (95 percent efficient where
// errors are normal; Holland & Welsch 1977). Here whole surfaces contradict, so Tukey's drops them
// from three on (chosen: 1 to 3; 2 to 3; with 6 a turn of 0.2 degrees is found with half as large a
// sigma again, and 0.02 degrees off).
constexpr double kHuber = 1.5;
constexpr double kTukey = 3;
// Standard deviation over median of the absolute values, of normal errors: 1 / 0.6745.
constexpr double kSigmaPerMedian = 1.48;
// The typical misfit counts as this much at least, or the little noise of a large smooth wall
// throws out all else (chosen: 0.3 to 1; 2 does what 6 does above).
constexpr double kLeastScale = 1;
// Along the width, for the jackknife: so large that what one thing does stays in one region
// (chosen: it changes sigma alone; with 2 it doubles, with 8 it falls by up to a half).
constexpr int kRegions = 4;

// What must be left of a diagonal element once the parameters before it explain theirs. A double
// holds it to 2e-16 of the sum it is the rest of, so three digits of it are true.
constexpr double kLeastPivot = 1e-13;

// Inverse of a symmetric positive definite matrix. `sum`: what it was computed from by subtraction,
// or the matrix itself. Nothing where a pivot is lost in the rounding of the sum: half an inverse
// is none.
std::optional<Matrix> inverse_of(Matrix m, const Matrix& sum) noexcept {
  for (std::size_t k = 0; k < kN; ++k) {
    const double pivot = m[k * kN + k];
    if (!(pivot > kLeastPivot * sum[k * kN + k])) {
      return std::nullopt;
    }
    m[k * kN + k] = 1;
    for (std::size_t j = 0; j < kN; ++j) {
      m[k * kN + j] /= pivot;
    }
    for (std::size_t i = 0; i < kN; ++i) {
      if (i == k) {
        continue;
      }
      const double factor = m[i * kN + k];
      m[i * kN + k] = 0;
      for (std::size_t j = 0; j < kN; ++j) {
        m[i * kN + j] -= factor * m[k * kN + j];
      }
    }
  }
  return m;
}

DriftVector times(const Matrix& m, const DriftVector& v) noexcept {
  DriftVector out{};
  for (std::size_t i = 0; i < kN; ++i) {
    for (std::size_t j = 0; j < kN; ++j) {
      out[i] += m[i * kN + j] * v[j];
    }
  }
  return out;
}

// Mean slope and error of a patch.
struct Equation {
  explicit Equation(const DriftPatch& patch) noexcept : error(patch.error / patch.weight()) {
    for (std::size_t k = 0; k < kN; ++k) {
      slope[k] = patch.slope[k] / patch.weight();
    }
    const double of_frame = patch.count / patch.weight();
    variance = kPatchNoisePx * kPatchNoisePx + of_frame * (kLasting + 1 / patch.count);
  }
  double left(const DriftVector& value) const noexcept {
    double sum = error;
    for (std::size_t k = 0; k < kN; ++k) {
      sum -= slope[k] * value[k];
    }
    return sum;
  }

  DriftVector slope{};
  double error;
  double variance = 0;
};

struct Normal {
  Matrix matrix{};
  DriftVector vector{};

  void add(const Equation& e, double target, double weight) noexcept {
    for (std::size_t i = 0; i < kN; ++i) {
      vector[i] += weight * e.slope[i] * target;
      for (std::size_t j = 0; j < kN; ++j) {
        matrix[i * kN + j] += weight * e.slope[i] * e.slope[j];
      }
    }
  }
};

// Of a misfit in units of the typical one.
double robust_weight(double misfit, int round) noexcept {
  if (round == 0) {
    return 1;
  }
  if (2 * round < kRounds) {
    return misfit < kHuber ? 1 : kHuber / misfit;
  }
  const double part = misfit / kTukey;
  return part < 1 ? (1 - part * part) * (1 - part * part) : 0;
}

// Fills trust, the weight of each patch, with what `value` leaves; returns the typical misfit of
// this round, for the next.
double weigh_patches(const DriftPatches& seen, const DriftVector& value, double scale,
                     int round) noexcept {
  std::size_t n = 0;
  for (std::size_t p = 0; p < seen.patches.size(); ++p) {
    seen.trust[p] = 0;
    if (!seen.patches[p].known()) {
      continue;
    }
    const Equation e(seen.patches[p]);
    const double misfit = std::abs(e.left(value)) / std::sqrt(e.variance);
    if (!std::isfinite(misfit)) {
      continue;
    }
    seen.sorted[n] = misfit;
    ++n;
    seen.trust[p] = robust_weight(misfit / scale, round) / (e.variance * scale * scale);
  }
  if (n == 0) {
    return scale;
  }
  const std::span<double> sorted = seen.sorted.first(n);
  std::ranges::nth_element(sorted, sorted.begin() + static_cast<std::ptrdiff_t>(n / 2));
  return std::max(kSigmaPerMedian * sorted[n / 2], kLeastScale);
}

// What is known before, and what the trusted patches say.
Normal normal_of(const DriftPatches& seen) noexcept {
  Normal out;
  for (std::size_t k = 0; k < kN; ++k) {
    out.matrix[k * kN + k] = 1 / (kPrior[k] * kPrior[k]);
  }
  for (std::size_t p = 0; p < seen.patches.size(); ++p) {
    if (seen.trust[p] > 0) {
      const Equation e(seen.patches[p]);
      out.add(e, e.error, seen.trust[p]);
    }
  }
  return out;
}

struct Region {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

// The first region of each way to lay them: squares, the same moved by half of one, and what
// stands or lies through the whole picture, such as the frame of a door or a skirting.
std::array<Region, 4> layouts_of(const DriftPatches& seen) noexcept {
  const int rows = static_cast<int>(seen.patches.size()) / seen.columns;
  const int side = std::max((seen.columns + kRegions - 1) / kRegions, 2);
  const int half = side / 2;
  return {{{.x = 0, .y = 0, .width = side, .height = side},
           {.x = -half, .y = -half, .width = side, .height = side},
           {.x = 0, .y = 0, .width = half, .height = rows},
           {.x = 0, .y = 0, .width = seen.columns, .height = half}}};
}

// What the patches of a region add to the matrix, and to the vector when it is measured from
// `value` (left) or when all of them are off by 1 px (shared).
struct Share {
  Normal left;
  DriftVector shared{};
  bool any = false;
};
Share share_of(const DriftPatches& seen, const Region& region, const DriftVector& value) noexcept {
  Share out;
  const int rows = static_cast<int>(seen.patches.size()) / seen.columns;
  for (int y = std::max(region.y, 0); y < std::min(region.y + region.height, rows); ++y) {
    for (int x = std::max(region.x, 0); x < std::min(region.x + region.width, seen.columns); ++x) {
      const std::size_t p = index(y * seen.columns + x);
      if (!(seen.trust[p] > 0)) {
        continue;
      }
      out.any = true;
      const Equation e(seen.patches[p]);
      out.left.add(e, e.left(value), seen.trust[p]);
      for (std::size_t k = 0; k < kN; ++k) {
        out.shared[k] += seen.trust[p] * e.slope[k];
      }
    }
  }
  return out;
}

// Variances by leaving out one region after the other.
// Nothing where the rest cannot be solved without one of them.
std::optional<DriftVector> jackknife(const DriftPatches& seen, const DriftVector& value,
                                     const Matrix& matrix, const Matrix& inverse,
                                     const Region& first) noexcept {
  const int rows = static_cast<int>(seen.patches.size()) / seen.columns;
  DriftVector squares{};
  DriftVector shared{};
  int regions = 0;
  for (int y = first.y; y < rows; y += first.height) {
    for (int x = first.x; x < seen.columns; x += first.width) {
      const Share share =
          share_of(seen, {.x = x, .y = y, .width = first.width, .height = first.height}, value);
      if (!share.any) {
        continue;
      }
      ++regions;
      Matrix rest = matrix;
      for (std::size_t k = 0; k < rest.size(); ++k) {
        rest[k] -= share.left.matrix[k];
      }
      const std::optional<Matrix> without = inverse_of(rest, matrix);
      if (!without) {
        return std::nullopt;
      }
      const DriftVector change = times(*without, share.left.vector);
      const DriftVector common = times(inverse, share.shared);
      for (std::size_t k = 0; k < kN; ++k) {
        squares[k] += change[k] * change[k];
        shared[k] += common[k] * common[k];
      }
    }
  }
  DriftVector out{};
  for (std::size_t k = 0; k < kN; ++k) {
    if (regions < 2) {
      out[k] = kPrior[k] * kPrior[k];
      continue;
    }
    out[k] = squares[k] * (regions - 1) / regions + shared[k] * kRegionNoisePx * kRegionNoisePx;
    // The draw to 0: all of the prior where the patches say nothing.
    for (std::size_t j = 0; j < kN; ++j) {
      const double drawn = inverse[k * kN + j] / kPrior[j];
      out[k] += drawn * drawn;
    }
  }
  return out;
}

}  // namespace

bool DriftPatch::known() const noexcept {
  constexpr double kLeastCount = 2;  // frames: of one alone nothing tells an outlier
  return count >= kLeastCount;
}

void DriftPatch::add(double error_px, const DriftVector& at, double variance) noexcept {
  for (std::size_t k = 0; k < kN; ++k) {
    slope[k] += at[k] / variance;
  }
  error += error_px / variance;
  count += 1;
}

void DriftPatch::fade(double factor) noexcept {
  constexpr double kForgotten = 1e-3;  // frames
  if (count < kForgotten) {
    *this = {};
    return;
  }
  for (double& s : slope) {
    s *= factor;
  }
  error *= factor;
  count *= factor;
}

std::optional<DriftSolution> solve_drift(const DriftPatches& seen) noexcept {
  DriftSolution out;
  Normal normal;
  std::optional<Matrix> inverse;
  double scale = 1;
  for (int round = 0; round < kRounds; ++round) {
    scale = weigh_patches(seen, out.value, scale, round);
    normal = normal_of(seen);
    inverse = inverse_of(normal.matrix, normal.matrix);
    if (!inverse) {
      return std::nullopt;
    }
    out.value = times(*inverse, normal.vector);
  }
  for (const Region& layout : layouts_of(seen)) {
    const std::optional<DriftVector> variance =
        jackknife(seen, out.value, normal.matrix, *inverse, layout);
    if (!variance) {
      return std::nullopt;
    }
    for (std::size_t k = 0; k < kN; ++k) {
      out.sigma[k] = std::max(out.sigma[k], std::sqrt((*variance)[k]));
    }
  }
  return out;
}

}  // namespace stof::dsp
