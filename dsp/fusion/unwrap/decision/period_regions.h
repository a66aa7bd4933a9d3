#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"

namespace stof::dsp {

// Pixels that see one surface, and the period that its brightest pixels prove: a forest of disjoint
// sets in which every pixel knows by how many periods it differs from its set's root.
class PeriodRegions {
 public:
  PeriodRegions(std::size_t pixels, Arena& arena) noexcept;

  // Every pixel its own set again.
  void clear() noexcept;
  // The surface goes on from a to b, and period(b) = period(a) + gain, gain -1, 0 or 1. A surface
  // that comes back to itself another period later is no surface: it will have no period.
  void unite(std::size_t a, std::size_t b, int gain) noexcept;

  // After all unite(): a pixel of which amplitude proves that it has period 0.
  void prove(std::size_t pixel) noexcept;
  // After all prove(): what else is known about a pixel's period.
  void contradict(std::size_t pixel, int period) noexcept;
  // The period of a pixel by its region: where kLeast pixels or more prove it, and kRobust times as
  // many as there are that speak against it. Else kUndecided.
  static constexpr int kUndecided = -1;
  static constexpr int kLeast = 3;
  static constexpr int kRobust = 16;
  int period(std::size_t pixel) noexcept;

 private:
  struct Place {
    std::size_t root;
    int gain;  // period(pixel) = period(root) + gain
  };
  Place find(std::size_t pixel) noexcept;

  std::span<std::int32_t> parent_;
  std::span<std::int16_t> gain_;  // to the parent
  // Of roots.
  std::span<std::int16_t> base_;  // period of the root by the proofs, kTwisted: it can have none
  std::span<std::int32_t> size_;
  std::span<std::int32_t> proofs_;
  std::span<std::int32_t> against_;
};

}  // namespace stof::dsp
