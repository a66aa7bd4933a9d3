#pragma once

#include <optional>

#include "dataset/dataset.h"
#include "lab/match_params.h"

// Parts of matching alone, once with the reference kernels ("plain": loops as the formulas are
// printed) and once as the appliance does it ("optimised").
namespace stof::host {

enum class Variant : std::uint8_t { kPlain, kOptimised };

// Median time in ms of all block costs of a pair: every pixel, every candidate, prefilter included.
// A row of costs is overwritten by the next one, as in the appliance. None for Cost::kAdCensus,
// which has no blocks.
std::optional<double> cost_matrix_ms(const dataset::StereoScene& scene,
                                     const lab::MatchParams& params, Variant variant, int runs);

}  // namespace stof::host
