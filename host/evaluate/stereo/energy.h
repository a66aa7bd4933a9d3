#pragma once

#include <cstdint>

#include "dataset/dataset.h"
#include "host/evaluate/stereo/match.h"

// Energy of whole maps, E = sum C + lambda sum |d - d'| over 4-neighbours, and its offline
// minimiser. C are the block costs of MatchParams; lambda is the small step of their smoothness.
namespace stof::host {

// The energy of a map matched with params; its disparities are rounded to whole pixels. Missing
// ones count for nothing, so only dense maps can be compared.
std::uint64_t energy_of(const dataset::StereoScene& scene, const lab::MatchParams& params,
                        const dataset::Image<dsp::Disparity>& disparity);

// Replaces the map by what annealing makes of it; the energy of the result.
std::uint64_t anneal_map(const dataset::StereoScene& scene, const lab::MatchParams& params,
                         lab::Acceptance acceptance, std::uint64_t seed,
                         dataset::Image<dsp::Disparity>& disparity);

}  // namespace stof::host
