#pragma once

#include <cstdint>
#include <span>

#include "dsp/stereo/cost/cost_source.h"
#include "lab/cost/cost_rows.h"
#include "lab/dsp_names.h"
#include "lab/match_params.h"

namespace stof::lab {

// Block sums on a scale that semi-global search can add up: times path_factor() (energy.h) over
// 65536, rounded; kNoCost stays.
class ScaledCosts final : public CostSource<std::uint16_t> {
 public:
  // rows: started, and there until the last row.
  void start(CostRows& rows, const MatchParams& params) noexcept;
  void row(int y, std::span<std::uint16_t> costs) noexcept override;

 private:
  CostRows* rows_ = nullptr;
  bool wide_ = false;
  std::uint32_t factor_ = 0;
};

}  // namespace stof::lab
