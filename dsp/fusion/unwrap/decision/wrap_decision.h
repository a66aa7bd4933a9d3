#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/fusion/unwrap/decision/distance_votes.h"
#include "dsp/fusion/unwrap/decision/surface_votes.h"
#include "dsp/fusion/unwrap/decision/wrap_regions.h"
#include "dsp/fusion/unwrap/evidence/amplitude_bound.h"
#include "dsp/fusion/unwrap/wrap_maps.h"

namespace stof::dsp {

// From what is known about every reading alone to its wrap count, or to none: readings around it
// that see the same surface, that lie at the same distance, that are bright.
class WrapDecision {
 public:
  // Readings that must stand behind a decision, itself included.
  static constexpr int kLeastAround = 3;

  // focal: of the PMD lens, the shorter of both. range: of the first frequency.
  WrapDecision(int pmd_width, int pmd_height, double focal, std::uint32_t range,
               Arena& arena) noexcept;

  // Fills wraps and seen of the maps; wraps below 0: not known.
  void decide(AmplitudeBound& bound, WrapMaps& maps) noexcept;

 private:
  void link_all(const WrapMaps& maps) noexcept;
  bool prevails(const WrapMaps& maps, int x, int y, int wanted) const noexcept;
  std::int8_t by_surface(const WrapMaps& maps, int x, int y) const noexcept;
  void decide_by_surfaces(WrapMaps& maps) noexcept;
  void join_regions(const WrapMaps& maps) noexcept;
  std::int8_t decide_last(const AmplitudeBound& bound, const WrapMaps& maps,
                          std::size_t i) noexcept;
  void drop_mixed(WrapMaps& maps) noexcept;
  bool may_be_mixed(const WrapMaps& maps, int x, int y) const noexcept;

  DistanceVotes window_;
  SurfaceVotes surfaces_;
  WrapRegions regions_;
  // On a surface of slope 2, distance changes by distance / slant_divisor_ per pixel.
  std::uint32_t slant_divisor_;
  std::span<std::int32_t> slants_;  // of a row
  std::span<std::uint8_t> open_;    // readings of unknown wrap count, a row of 0 before and behind
  std::span<std::uint8_t>
      beside_;  // whether one of them is beside a pixel, or at a row's other end
};

}  // namespace stof::dsp
