#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/pmd/phase/frame_phases.h"
#include "dsp/pmd/phase/phase.h"

namespace stof::dsp {

// What motion between the four samples of an exposure does to phases, found, taken away, and told.
// Where brightness changes by g from sample to sample, I = A0 - A2 is off by -2 g, Q = A3 - A1 by
// 2 g, and A0 + A2 - A1 - A3, which is 0 on a standing scene whatever the phase, is u = -2 g: the
// samples themselves tell their error.
//
// Only near cells of kCell x kCell pixels of which kLeastAsymmetric are flagged kPmdAsymmetric, so
// that noise of a standing scene changes nothing. There, of pixels that are neither saturated nor
// under range, with sd the noise of u and `limit` what the flag asks for:
//   c = |u| - sd with the sign of u, where sd < |u| <= kMostLimits limits; else 0
//   I and Q are measured anew as I - c and Q + c, from samples whose sum stays; other flags and
//     amplitudes are those of the new samples
//   sigma' = sqrt(sigma^2 + more^2), more^2 = 2 (sigma c / u)^2 + (kLeftOver (distance that c is
//     worth))^2: the noise that u brings, and what a change leaves that is not linear
class MotionCorrection {
 public:
  static constexpr int kCell = 16;  // pixels a side
  static constexpr int kReach = 1;  // cells around one
  static constexpr int kLeastAsymmetric = 2;
  static constexpr float kMostLimits = 6;
  // Fitted to drives through corridor and hall at 0.5 to 1.5 m/s.
  static constexpr float kLeftOver = 0.354F;

  MotionCorrection(int width, int height, Arena& arena) noexcept;

  // Looks at a frame's flags. Whether anything moved while its samples were taken.
  bool look(const ImageView<std::uint8_t>& flags) noexcept;

  // Row y of a frame of one exposure that moved, whose phases were measured of these samples:
  // measures anew what changes. The sigma of `out` is that of the new amplitude; more: of each
  // pixel, for widen(). Writes over `spare`.
  void correct(const SampleRows& samples, const FrameTables& tables, int y,
               const ExposureRow& spare, const ExposureRow& out,
               std::span<QuarterMm> more) const noexcept;
  // The same row's sigma, in quarter mm of distance; 0 stays 0.
  void widen(int y, std::span<const QuarterMm> more, std::span<QuarterMm> sigma) const noexcept;

 private:
  bool touches(int y) const noexcept;
  void mark_around(int column, int row) noexcept;

  ImageView<std::uint8_t> near_;  // of each cell: one within kReach is asymmetric
};

}  // namespace stof::dsp
