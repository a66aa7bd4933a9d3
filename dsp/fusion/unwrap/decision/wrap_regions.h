#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/index.h"

namespace stof::dsp {

// Pixels that see one surface, and the wrap count that its brightest pixels prove: a forest of
// disjoint sets in which every pixel knows how many wraps lie between it and its set's root.
class WrapRegions {
 public:
  WrapRegions(std::size_t pixels, Arena& arena) noexcept;

  // Every pixel its own set again.
  void clear() noexcept;
  // The surface goes on from a to b, and wraps(b) = wraps(a) + gain, gain -1, 0 or 1. A surface
  // that comes back to itself one wrap later is no surface: its wrap count stays unknown.
  void unite(std::size_t a, std::size_t b, int gain) noexcept;
  // Whether no other pixel is in its set: what it proves counts for itself alone.
  bool stands_alone(std::size_t pixel) const noexcept {
    return size_[pixel] == 1 && index(parent_[pixel]) == pixel;
  }

  // After all unite(): a pixel that has not wrapped: its amplitude proves it.
  void prove(std::size_t pixel) noexcept;
  // After all prove(): what else is known about a pixel's wrap count.
  void contradict(std::size_t pixel, int wraps) noexcept;
  // The wrap count of a pixel by its region: where kLeast pixels or more prove it, and kRobust
  // times as many as there are that speak against it. Else kUndecided.
  static constexpr int kUndecided = -1;
  static constexpr int kLeast = 3;
  static constexpr int kRobust = 16;
  int wraps(std::size_t pixel) noexcept;

 private:
  struct Place {
    std::size_t root;
    int gain;  // wraps(pixel) = wraps(root) + gain
  };
  Place find(std::size_t pixel) noexcept;

  std::span<std::int32_t> parent_;
  std::span<std::int16_t> gain_;  // to the parent
  // For roots alone. base_: the wrap count by the proofs; kTwisted: it can have none.
  std::span<std::int16_t> base_;
  std::span<std::int32_t> size_;
  std::span<std::int32_t> proofs_;
  std::span<std::int32_t> against_;
};

}  // namespace stof::dsp
