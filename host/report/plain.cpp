#include "host/report/plain.h"

#include "dsp/stereo/prepared_pair.h"
#include "host/evaluate/stereo/match.h"
#include "host/report/plain_costs.h"
#include "lab/cost/cost_rows.h"

namespace stof::host {
namespace {

using lab::Cost;

bool has_block_costs(const lab::MatchParams& params) { return params.cost != Cost::kAdCensus; }

// Calls use(row) for all rows of block costs, as the appliance makes them.
template <typename Sum, typename Use>
void for_appliance_rows(const dataset::StereoScene& scene, const lab::MatchParams& params,
                        Workspace& workspace, const Use& use) {
  dsp::Arena arena = workspace.arena();
  const int width = scene.left.width;
  const int height = scene.left.height;
  dsp::PreparedPair pair(params, width, height, arena);
  lab::CostRows rows(params, width, arena);
  pair.start(scene.left.view(), scene.right.view());
  pair.filter({0, height});
  pair.derive({0, height});
  dsp::CostPictures pictures;
  pictures.left = pair.left();
  pictures.right = pair.right();
  rows.start(pictures);
  for (int y = 0; y < height; ++y) {
    use(rows.row<Sum>(y), rows.lanes());
  }
}

Workspace appliance_workspace(const dataset::StereoScene& scene, const lab::MatchParams& params) {
  return Workspace(dsp::bytes_taken([&](dsp::Arena& arena) {
    dsp::PreparedPair(params, scene.left.width, scene.left.height, arena);
    lab::CostRows(params, scene.left.width, arena);
  }));
}

template <typename Sum>
double cost_matrix_with(const dataset::StereoScene& scene, const lab::MatchParams& params,
                        Variant variant, int runs) {
  if (variant == Variant::kOptimised) {
    Workspace workspace = appliance_workspace(scene, params);
    return median_time_ms(runs, [&] {
      for_appliance_rows<Sum>(scene, params, workspace,
                              [](std::span<const Sum> /*costs*/, int /*lanes*/) {});
    });
  }
  return median_time_ms(runs, [&] {
    PlainCosts<Sum> rows(scene, params);
    for (int y = 0; y < rows.height(); ++y) {
      rows.row(y);
    }
  });
}

}  // namespace

std::optional<double> cost_matrix_ms(const dataset::StereoScene& scene,
                                     const lab::MatchParams& params, Variant variant, int runs) {
  if (!has_block_costs(params)) {
    return std::nullopt;
  }
  return lab::CostRows::wide(params)
             ? cost_matrix_with<std::uint32_t>(scene, params, variant, runs)
             : cost_matrix_with<std::uint16_t>(scene, params, variant, runs);
}

}  // namespace stof::host
