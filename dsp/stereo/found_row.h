#pragma once

#include <cstdint>
#include <span>

namespace stof::dsp {

// The result of a search in one row; layouts of cost/sad.h and search/winner.h.
template <typename Cost, typename Sum = Cost>
struct FoundRow {
  std::span<const Cost> costs;  // for all candidates, whatever a guide says
  // The values that the winners minimise: costs or path sums, only of candidates that the guide
  // allows.
  std::span<const Sum> judged;
  std::span<std::int16_t> winners;
  bool numbered = false;  // costs and judged are numbered_cost() each (search/block_winners.h)
};

}  // namespace stof::dsp
