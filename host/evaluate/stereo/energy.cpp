#include "host/evaluate/stereo/energy.h"

#include <algorithm>
#include <vector>

#include "dsp/base/index.h"
#include "dsp/stereo/cost/cost_layout.h"
#include "dsp/stereo/search/winner.h"
#include "host/evaluate/stereo/block_costs.h"
#include "lab/search/energy.h"

namespace stof::host {
namespace {

// Always u32: the maps of u16 costs come to the same.
struct Volume {
  std::vector<std::uint32_t> costs = {};
  int lanes = 0;
  std::uint32_t lambda = 0;
};

Volume volume_of(const dataset::StereoScene& scene, lab::MatchParams params) {
  params.method = lab::Method::kWinnerTakesAll;
  params.band.reset();
  Volume volume{.lanes = dsp::lanes_of(params),
                .lambda = lab::block_penalties<std::uint32_t>(params).small};
  volume.costs.reserve(scene.left.pixels.size() * dsp::index(volume.lanes));
  BlockCosts<std::uint32_t>(scene, params).each_row([&](std::span<const std::uint32_t> costs) {
    volume.costs.insert(volume.costs.end(), costs.begin(), costs.end());
  });
  return volume;
}

dataset::Image<std::int16_t> candidates_of(const dataset::Image<dsp::Disparity>& disparity,
                                           const lab::MatchParams& params) {
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

std::uint64_t energy_of(const dataset::StereoScene& scene, const lab::MatchParams& params,
                        const dataset::Image<dsp::Disparity>& disparity) {
  const Volume volume = volume_of(scene, params);
  const dataset::Image<std::int16_t> map = candidates_of(disparity, params);
  return lab::map_energy(std::span<const std::uint32_t>(volume.costs), volume.lanes, volume.lambda,
                         map.view());
}

std::uint64_t anneal_map(const dataset::StereoScene& scene, const lab::MatchParams& params,
                         lab::Acceptance acceptance, std::uint64_t seed,
                         dataset::Image<dsp::Disparity>& disparity) {
  const Volume volume = volume_of(scene, params);
  dataset::Image<std::int16_t> map = candidates_of(disparity, params);
  lab::AnnealingParams how = lab::default_annealing(volume.lambda);
  how.acceptance = acceptance;
  how.seed = seed;
  dataset::Image<std::int16_t> best{map.width, map.height};
  const lab::AnnealingEnergy energy = lab::anneal(std::span<const std::uint32_t>(volume.costs),
                                                  volume.lanes, how, best.view(), map.view());
  std::ranges::transform(map.pixels, disparity.pixels.begin(), [&](std::int16_t candidate) {
    return candidate == dsp::kNoWinner
               ? dsp::Disparity::none()
               : dsp::Disparity::from_pixels(params.min_disparity + candidate);
  });
  return energy.end;
}

}  // namespace stof::host
