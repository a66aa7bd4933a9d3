#include "host/evaluate/stereo/energy.h"

#include <algorithm>
#include <vector>

#include "dsp/stereo/cost/cost_layout.h"
#include "dsp/stereo/prepared_pair.h"
#include "dsp/stereo/row_search.h"
#include "dsp/stereo/search/energy.h"
#include "dsp/stereo/search/winner.h"

namespace stof::host {
namespace {

std::size_t size(int value) { return static_cast<std::size_t>(value); }

// Always u32: the maps of u16 costs come to the same.
struct Volume {
  std::vector<std::uint32_t> costs = {};
  int lanes = 0;
  std::uint32_t lambda = 0;
};

Volume volume_of(const dataset::StereoScene& scene, dsp::MatchParams params) {
  params.method = dsp::Method::kWinnerTakesAll;
  params.band.reset();
  const int width = scene.left.width;
  const int height = scene.left.height;
  Workspace workspace(dsp::PreparedPair::bytes_needed(params, width, height) +
                      dsp::RowSearch<std::uint32_t>::bytes_needed(params, width));
  dsp::Arena arena = workspace.arena();
  dsp::PreparedPair pair(params, width, height, arena);
  dsp::RowSearch<std::uint32_t> search(params, width, arena);
  pair.start(scene.left.view(), scene.right.view());
  pair.filter({0, height});
  pair.derive({0, height});
  search.start(pair, {});
  Volume volume{.lanes = dsp::lanes_of(params),
                .lambda = dsp::block_penalties<std::uint32_t>(params).small};
  volume.costs.reserve(size(width) * size(height) * size(volume.lanes));
  for (int y = 0; y < height; ++y) {
    const dsp::FoundRow<std::uint32_t> found = search.row(y);
    volume.costs.insert(volume.costs.end(), found.costs.begin(), found.costs.end());
  }
  return volume;
}

dataset::Image<std::int16_t> candidates_of(const dataset::Image<dsp::Disparity>& disparity,
                                           const dsp::MatchParams& params) {
  dataset::Image<std::int16_t> map{disparity.width, disparity.height};
  const auto candidate = [&](dsp::Disparity d) -> std::int16_t {
    if (!d.valid()) {
      return dsp::kNoWinner;
    }
    const int whole = (d.raw + dsp::Disparity::kOne / 2) >> dsp::Disparity::kFractionBits;
    return static_cast<std::int16_t>(
        std::clamp(whole - params.min_disparity, 0, params.disparities - 1));
  };
  std::ranges::transform(disparity.pixels, map.pixels.begin(), candidate);
  return map;
}

}  // namespace

std::uint64_t energy_of(const dataset::StereoScene& scene, const dsp::MatchParams& params,
                        const dataset::Image<dsp::Disparity>& disparity) {
  const Volume volume = volume_of(scene, params);
  const dataset::Image<std::int16_t> map = candidates_of(disparity, params);
  return dsp::map_energy(std::span<const std::uint32_t>(volume.costs), volume.lanes, volume.lambda,
                         map.view());
}

std::uint64_t anneal_map(const dataset::StereoScene& scene, const dsp::MatchParams& params,
                         dsp::Acceptance acceptance, std::uint64_t seed,
                         dataset::Image<dsp::Disparity>& disparity) {
  const Volume volume = volume_of(scene, params);
  dataset::Image<std::int16_t> map = candidates_of(disparity, params);
  dsp::AnnealingParams how = dsp::default_annealing(volume.lambda);
  how.acceptance = acceptance;
  how.seed = seed;
  Workspace workspace(dsp::annealing_bytes_needed(map.width, map.height));
  const dsp::AnnealingEnergy energy = dsp::anneal(std::span<const std::uint32_t>(volume.costs),
                                                  volume.lanes, how, workspace.arena(), map.view());
  std::ranges::transform(map.pixels, disparity.pixels.begin(), [&](std::int16_t candidate) {
    return candidate == dsp::kNoWinner
               ? dsp::Disparity::none()
               : dsp::Disparity::from_pixels(params.min_disparity + candidate);
  });
  return energy.end;
}

}  // namespace stof::host
