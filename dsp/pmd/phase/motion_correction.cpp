#include "dsp/pmd/phase/motion_correction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>

#include "dsp/base/index.h"
#include "dsp/pmd/interval/sigma.h"
#include "dsp/pmd/pmd_maps.h"

namespace stof::dsp {
namespace {

using Samples = std::array<int, 4>;

constexpr float kRootOfTwo = 1.41421356F;

int cells(int size) noexcept {
  return (size + MotionCorrection::kCell - 1) / MotionCorrection::kCell;
}

// c, see motion_correction.h; u is A0 + A2 - A1 - A3.
int change_between(int u, const Samples& a, const FrameTables& tables) noexcept {
  const PhaseLimits& limits = tables.exposures[0].limits;
  const int mean = (a[0] + a[1] + a[2] + a[3] + 2) / 4;
  const auto light = static_cast<std::uint32_t>(std::max(mean - limits.dark, 0));
  const std::uint64_t squared =
      std::uint64_t{limits.asymmetry_base} + ((limits.asymmetry_slope_q8 * light) >> 8U);
  const float limit = std::sqrt(static_cast<float>(std::min<std::uint64_t>(squared, 0xFFFFFFFF)));
  const float uneven = static_cast<float>(std::abs(u));
  const float beyond = uneven - limit * tables.frequency.per_asymmetry_limit;
  if (!(beyond > 0) || uneven > MotionCorrection::kMostLimits * limit) {
    return 0;
  }
  const int size = static_cast<int>(std::lround(beyond));
  return u < 0 ? -size : size;
}

// Samples of which a change of c between them is taken away; usable ones stay usable.
Samples without(int c, const Samples& a, const PhaseLimits& limits) noexcept {
  const int outer = (3 * std::abs(c) + 2) / 4 * (c < 0 ? -1 : 1);
  const int inner = c - outer;
  Samples out{a[0] - outer, a[1] - inner, a[2] + inner, a[3] + outer};
  for (int& sample : out) {
    sample =
        std::clamp<int>(sample, limits.lowest, std::max<int>(limits.lowest, limits.saturation - 1));
  }
  return out;
}

QuarterMm root_of_squares(float a, float b) noexcept {
  return static_cast<QuarterMm>(std::min(std::sqrt(a * a + b * b) + 0.5F, float{kMaxQuarterMm}));
}

// Of a pixel of this sigma and amplitude, before c was taken away.
QuarterMm more_sigma(int c, int u, QuarterMm sigma, std::uint16_t amp2, float sigma_unit) noexcept {
  const float size = static_cast<float>(std::abs(c));
  const float noise = static_cast<float>(sigma) * size / static_cast<float>(std::abs(u));
  const float worth = size * sigma_unit / static_cast<float>(std::max<int>(amp2, 1));
  return root_of_squares(kRootOfTwo * noise, MotionCorrection::kLeftOver * worth);
}

bool some_asymmetric(const ImageView<std::uint8_t>& flags, Rows rows) noexcept {
  std::uint8_t any = 0;  // in bytes: vectors
  for (int y = rows.begin; y < rows.end; ++y) {
    for (const std::uint8_t flag : flags.row(y)) {
      any = static_cast<std::uint8_t>(any | flag);
    }
  }
  return (any & kPmdAsymmetric) != 0;
}

// Of one cell.
int count_asymmetric(const ImageView<std::uint8_t>& flags, Rows rows, int column) noexcept {
  int count = 0;
  const int end = std::min((column + 1) * MotionCorrection::kCell, flags.width());
  for (int y = rows.begin; y < rows.end; ++y) {
    for (int x = column * MotionCorrection::kCell; x < end; ++x) {
      count += (flags.at(x, y) & kPmdAsymmetric) != 0 ? 1 : 0;
    }
  }
  return count;
}

}  // namespace

MotionCorrection::MotionCorrection(int width, int height, Arena& arena) noexcept
    : near_(arena.take_image<std::uint8_t>(cells(width), cells(height))) {}

void MotionCorrection::mark_around(int column, int row) noexcept {
  for (int y = std::max(row - kReach, 0); y <= std::min(row + kReach, near_.height() - 1); ++y) {
    for (int x = std::max(column - kReach, 0); x <= std::min(column + kReach, near_.width() - 1);
         ++x) {
      near_.at(x, y) = 1;
    }
  }
}

bool MotionCorrection::look(const ImageView<std::uint8_t>& flags) noexcept {
  bool moved = false;
  for (int row = 0; row < near_.height(); ++row) {
    std::ranges::fill(near_.row(row), std::uint8_t{0});
  }
  for (int row = 0; row < near_.height(); ++row) {
    const Rows rows{row * kCell, std::min((row + 1) * kCell, flags.height())};
    if (!some_asymmetric(flags, rows)) {
      continue;
    }
    for (int column = 0; column < near_.width(); ++column) {
      if (count_asymmetric(flags, rows, column) >= kLeastAsymmetric) {
        mark_around(column, row);
        moved = true;
      }
    }
  }
  return moved;
}

bool MotionCorrection::touches(int y) const noexcept {
  return std::ranges::max(near_.row(y / kCell)) != 0;
}

void MotionCorrection::correct(const SampleRows& samples, const FrameTables& tables, int y,
                               const ExposureRow& spare, const ExposureRow& out,
                               std::span<QuarterMm> more) const noexcept {
  if (!touches(y)) {
    return;
  }
  const ExposureTables& exposure = tables.exposures[0];
  const std::span<const std::uint8_t> near = near_.row(y / kCell);
  const std::array corrected{spare.phase, spare.amp2, spare.offset, spare.sigma};
  const std::size_t n = out.flags.size();
  std::ranges::fill(more, QuarterMm{0});
  for (std::size_t x = 0; x < n; ++x) {
    const Samples a{samples[0][x], samples[1][x], samples[2][x], samples[3][x]};
    const int u = a[0] + a[2] - a[1] - a[3];
    const bool usable = (out.flags[x] & (kPmdSaturated | kPmdUnderRange)) == 0;
    const int c = near[x / kCell] != 0 && usable ? change_between(u, a, tables) : 0;
    const Samples b = c == 0 ? a : without(c, a, exposure.limits);
    for (std::size_t k = 0; k < b.size(); ++k) {
      corrected[k][x] = static_cast<std::uint16_t>(b[k]);
    }
    if (c != 0) {
      more[x] = more_sigma(c, u, out.sigma[x], out.amp2[x], tables.frequency.sigma_unit);
    }
  }
  best::phase({corrected[0], corrected[1], corrected[2], corrected[3]}, exposure.limits,
              {out.phase, out.amp2, out.offset, out.flags});
  best::sigma_and_ratio(out.amp2, out.offset, exposure.noise, out.sigma, out.ratio);
}

void MotionCorrection::widen(int y, std::span<const QuarterMm> more,
                             std::span<QuarterMm> sigma) const noexcept {
  if (!touches(y)) {
    return;
  }
  for (std::size_t x = 0; x < sigma.size(); ++x) {
    if (sigma[x] != 0 && more[x] != 0) {
      sigma[x] = root_of_squares(sigma[x], more[x]);
    }
  }
}

}  // namespace stof::dsp
