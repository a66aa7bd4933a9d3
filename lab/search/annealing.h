#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/image.h"
#include "dsp/stereo/cost/sad.h"
#include "lab/dsp_names.h"

// Simulated annealing on a whole picture: slow, for comparison with the methods that are not.
// Energy of a map of candidates:
//
//   sum of costs[y][x][map(x, y)]  +  lambda * sum over 4-neighbours of |difference of candidates|
//
// Pixels without a candidate (kNoWinner of winner.h) count for nothing. The same seed gives the
// same map on every processor. Source: Metropolis et al. 1953; Kirkpatrick et al. 1983.
namespace stof::lab {

enum class Acceptance : std::uint8_t {
  kMetropolis,    // a rise by `temperature` is accepted with probability 1/2, by twice it 1/4, ...
  kHillClimbing,  // no rise is accepted
};

struct AnnealingParams {
  Acceptance acceptance = Acceptance::kMetropolis;
  std::uint32_t lambda = 0;  // in the units of the costs
  std::uint64_t seed = 1;
  int sweeps = 600;  // visits to each pixel, at least 1
  // At the first sweep, in the units of the costs; it is halved `halvings` times until the last.
  std::uint32_t temperature = 0;
  int halvings = 7;  // 0..31
};

// A schedule for lambda that serves all pictures.
AnnealingParams default_annealing(std::uint32_t lambda) noexcept;

struct AnnealingEnergy {
  std::uint64_t start = 0;
  std::uint64_t end = 0;  // never above start
};

// costs: a volume [row][column][candidate], map.width() * map.height() * lanes; u16 or u32.
template <typename Sum>
std::uint64_t map_energy(std::span<const Sum> costs, int lanes, std::uint32_t lambda,
                         ImageView<const std::int16_t> map) noexcept;

// map: where to begin, as winner.h or a filter leaves it, and the result: the best map met, after a
// descent in which no change of one pixel lowers the energy. Pixels whose winner is none of their
// candidates begin with the cheapest, unless no pixel has a winner: then the map stays. best:
// scratch of the map's size.
template <typename Sum>
AnnealingEnergy anneal(std::span<const Sum> costs, int lanes, const AnnealingParams& params,
                       ImageView<std::int16_t> best, ImageView<std::int16_t> map) noexcept;

}  // namespace stof::lab
