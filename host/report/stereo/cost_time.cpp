#include "host/report/stereo/cost_time.h"

#include "dsp/base/target.h"
#include "host/evaluate/stereo/block_costs.h"
#include "host/evaluate/stereo/match.h"
#include "lab/cost/cost_rows.h"

namespace stof::host {
namespace {

template <typename Sum>
double time_of_rows(const dataset::StereoScene& scene, const lab::MatchParams& params, int runs) {
  BlockCosts<Sum> costs(scene, params);
  return median_time_ms(runs, [&] { costs.each_row([](std::span<const Sum> /*row*/) {}); });
}

}  // namespace

std::optional<double> cost_matrix_ms(const dataset::StereoScene& scene,
                                     const lab::MatchParams& params, int runs) {
  if (params.cost == lab::Cost::kAdCensus) {
    return std::nullopt;
  }
  return lab::CostRows::wide(params) ? time_of_rows<std::uint32_t>(scene, params, runs)
                                     : time_of_rows<std::uint16_t>(scene, params, runs);
}

std::optional<double> plain_cost_matrix_ms(const dataset::StereoScene& scene,
                                           const lab::MatchParams& params, int runs) {
  const dsp::UseVectors reference(dsp::Vectors::kRef);
  return cost_matrix_ms(scene, params, runs);
}

}  // namespace stof::host
