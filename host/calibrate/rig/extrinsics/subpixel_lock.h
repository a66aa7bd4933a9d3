#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "host/calibrate/rig/extrinsics/wall_plane.h"

// A matcher pulls disparities towards whole pixels ("pixel locking": Shimizu and Okutomi, ICCV
// 2001), here by up to 0.1 px, whatever the picture: by how much depends on what is behind the
// point alone. Tilted walls go through all of that, so their planes tell it; one that faces the
// pair has but a part of a pixel, and would be taken for a wall that is tilted by a third of a
// degree.
namespace stof::host {

class SubpixelLock {
 public:
  // A wall of the pair; one whose disparities are alike tells nothing.
  void add(const std::vector<PlaneLook>& looks, const SeenPlane& plane);
  // Looks of the same matcher, without it.
  std::vector<PlaneLook> undone(std::vector<PlaneLook> looks) const;

 private:
  static constexpr std::size_t kParts = 16;  // of a pixel, as disparities have

  static std::size_t part_of(const PlaneLook& look);

  std::array<double, kParts> sums_px_{};
  std::array<double, kParts> counts_{};
};

}  // namespace stof::host
