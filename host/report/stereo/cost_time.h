#pragma once

#include <optional>

#include "dataset/dataset.h"
#include "lab/match_params.h"

// Times of one part of matching alone: the block costs of a pair.
namespace stof::host {

// Median time in ms of all block costs: every pixel, every candidate, prefilter included. A row of
// costs is overwritten by the next one, as in the appliance. None for Cost::kAdCensus, which has no
// blocks.
std::optional<double> cost_matrix_ms(const dataset::StereoScene& scene,
                                     const lab::MatchParams& params, int runs);
// The same with the reference kernels: loops as the formulas are printed.
std::optional<double> plain_cost_matrix_ms(const dataset::StereoScene& scene,
                                           const lab::MatchParams& params, int runs);

}  // namespace stof::host
