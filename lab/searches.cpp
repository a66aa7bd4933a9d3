#include "lab/searches.h"

#include <cstdint>

#include "lab/search/cost_search.h"
#include "lab/search/energy.h"
#include "lab/search/map_search.h"
#include "lab/search/wide_semi_global_search.h"

namespace stof::lab {

RowSearch* Searches::make(const dsp::MatchParams& params, int width, int height,
                          Arena& arena) noexcept {
  static_cast<dsp::MatchParams&>(params_) = params;
  if (MapSearch::serves(params_)) {
    map_search_ = made_ ? map_search_ : arena.make<MapSearch>(params_, width, height);
    made_ = true;
    return map_search_;
  }
  if (params_.method == Method::kSemiGlobal) {
    return params_.cost == Cost::kAdCensus
               ? static_cast<RowSearch*>(
                     arena.make<WideSemiGlobalSearch<AdCensusSource>>(params_, width))
               : arena.make<WideSemiGlobalSearch<BlockSource>>(params_, width);
  }
  return needs_wide_sums(params_) ? make_cost_search<std::uint32_t>(width, arena)
                                  : make_cost_search<std::uint16_t>(width, arena);
}

template <typename Sum>
RowSearch* Searches::make_cost_search(int width, Arena& arena) const noexcept {
  switch (params_.method) {
    case Method::kDynamicProgramming:
      return arena.make<DynamicProgrammingSearch<Sum>>(params_, continued_, width);
    case Method::kScanlineOptimisation:
      return arena.make<ScanlineOptimisationSearch<Sum>>(params_, width);
    case Method::kWinnerTakesAll:
    case Method::kSemiGlobal:
      break;
  }
  return arena.make<WinnerSearch<Sum>>(params_, width);
}

int Searches::rows_at_once(int height) const noexcept {
  constexpr int kRows = 16;  // sums over blocks begin anew where a thread takes over another's
  if (MapSearch::serves(params_)) {
    return height;
  }
  return params_.method == Method::kSemiGlobal
             ? WideSemiGlobalSearch<AdCensusSource>::Paths::kStripe
             : kRows;
}

}  // namespace stof::lab
