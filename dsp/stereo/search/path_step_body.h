#pragma once

#include <cstddef>

#include "dsp/stereo/search/path_costs.h"

// One pixel of a path, for path_costs_body.h. Isa: Lanes<Cost> of base/lanes_neon.h or
// lanes_avx2.h, in an unnamed namespace.
namespace stof::dsp::path_costs_body {

inline constexpr std::size_t kMostLanes = 256;

// kVectors vectors of candidates, or, where it is 0, as many as `lanes` holds: a known count is
// unrolled. Along a row each pixel waits for the minimum of the one before, so that the minimum is
// formed from registers while the pixel is stored; the paths themselves come back from L1 sooner
// than the minimum is known.
template <typename Isa, std::size_t kVectors>
class Step {
 public:
  using Cost = typename Isa::Lane;
  using V = typename Isa::V;
  static constexpr std::size_t kStep = Isa::kLanes;

  Step(int lanes, Cost small) noexcept
      : vectors_(kVectors != 0 ? kVectors : static_cast<std::size_t>(lanes) / kStep),
        small_(Isa::all(small)) {}

  std::size_t lanes() const noexcept { return vectors_ * kStep; }

  // The lowest in every lane.
  V lowest(const Cost* paths) const noexcept {
    V least = Isa::load(paths);
    for (std::size_t v = 1; v < vectors_; ++v) {
      least = Isa::smaller(least, Isa::load(paths + v * kStep));
    }
    return Isa::lowest(least);
  }

  // A pixel with none before it: put(i, path) is given its lanes from i on.
  template <typename Put>
  V start(const Cost* costs, Put put) const noexcept {
    for (std::size_t v = 0; v < vectors_; ++v) {
      put(v * kStep, Isa::load(costs + v * kStep));
    }
    return lowest(costs);
  }

  // lowest: of `before`, in every lane. Returns that of the paths, which put(i, path) is given;
  // they may go where `before` was.
  template <typename Put>
  V go(const Cost* costs, const Cost* before, V lowest, Cost large, Put put) const noexcept {
    const V jump = Isa::add_saturated(lowest, Isa::all(large));
    const V none = Isa::all(kNoCost<Cost>);
    V previous = none;
    V here = Isa::load(before);
    V least = none;
    for (std::size_t v = 0; v < vectors_; ++v) {
      const V next = v + 1 < vectors_ ? Isa::load(before + (v + 1) * kStep) : none;
      const V neighbours = Isa::smaller(Isa::one_up(previous, here), Isa::one_down(here, next));
      const V step = Isa::add_saturated(neighbours, small_);
      const V best = Isa::smaller(Isa::smaller(here, step), jump);
      const V path = Isa::add_saturated(Isa::load(costs + v * kStep), best - lowest);
      put(v * kStep, path);
      least = Isa::smaller(least, path);
      previous = here;
      here = next;
    }
    return Isa::lowest(least);
  }

 private:
  std::size_t vectors_;
  V small_;
};

template <typename Isa>
auto store_to(typename Isa::Lane* paths) noexcept {
  return [paths](std::size_t i, typename Isa::V path) noexcept { Isa::store(paths + i, path); };
}

// work.template operator()<kVectors>(): counts that frames are matched with are known ones.
template <typename Isa, typename Work>
void with_known_count(int lanes, Work work) noexcept {
  constexpr std::size_t k64 = 64 / Isa::kLanes;
  constexpr std::size_t k128 = 128 / Isa::kLanes;
  switch (lanes) {
    case 64:
      return work.template operator()<k64>();
    case 128:
      return work.template operator()<k128>();
    default:
      return work.template operator()<0>();
  }
}

}  // namespace stof::dsp::path_costs_body
