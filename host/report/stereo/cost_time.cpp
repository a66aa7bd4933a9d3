#include "host/report/stereo/cost_time.h"

#include "dsp/base/target.h"
#include "dsp/stereo/prepared_pair.h"
#include "host/evaluate/stereo/match.h"
#include "lab/cost/cost_rows.h"

namespace stof::host {
namespace {

template <typename Sum>
double time_of_rows(const dataset::StereoScene& scene, const lab::MatchParams& params, int runs) {
  const int width = scene.left.width;
  const int height = scene.left.height;
  Workspace workspace(dsp::bytes_taken([&](dsp::Arena& arena) {
    dsp::PreparedPair(params, width, height, arena);
    lab::CostRows(params, width, arena);
  }));
  return median_time_ms(runs, [&] {
    dsp::Arena arena = workspace.arena();
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
      rows.row<Sum>(y);
    }
  });
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
