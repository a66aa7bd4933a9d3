#include "host/report/plain_costs.h"

#include <algorithm>
#include <cstdlib>

#include <gtest/gtest.h>

#include "dsp/stereo/cost/sad.h"
#include "dsp/stereo/prepared_pair.h"
#include "host/evaluate/workspace.h"
#include "lab/cost/cost_rows.h"

namespace stof::host {
namespace {

dataset::StereoScene random_scene(int width, int height) {
  dataset::StereoScene scene;
  scene.left = {width, height};
  scene.right = {width, height};
  std::uint32_t state = 12345;
  for (dataset::Image<std::uint8_t>* picture : {&scene.left, &scene.right}) {
    for (std::uint8_t& value : picture->pixels) {
      state = state * 1664525 + 1013904223;
      value = static_cast<std::uint8_t>(state >> 24);
    }
  }
  scene.ndisp = 7;
  return scene;
}

std::uint8_t clamped(const dataset::Image<std::uint8_t>& picture, int x, int y) {
  return picture.view().row_clamped(
      y)[static_cast<std::size_t>(std::clamp(x, 0, picture.width - 1))];
}

// The formula of SPEC section 1: sums over the block with replicated borders.
std::uint32_t block_difference(const dataset::StereoScene& scene, const lab::MatchParams& params,
                               int x, int y, int d) {
  std::uint32_t sum = 0;
  for (int dy = -(params.block_height / 2); dy < params.block_height - params.block_height / 2;
       ++dy) {
    for (int dx = -(params.block_width / 2); dx < params.block_width - params.block_width / 2;
         ++dx) {
      const int difference =
          clamped(scene.left, x + dx, y + dy) - clamped(scene.right, x + dx - d, y + dy);
      sum += static_cast<std::uint32_t>(params.cost == lab::Cost::kSsd ? difference * difference
                                                                       : std::abs(difference));
    }
  }
  return sum;
}

lab::MatchParams params_of(lab::Cost cost, int width, int height) {
  lab::MatchParams params;
  params.disparities = 7;
  params.cost = cost;
  params.block_width = width;
  params.block_height = height;
  params.prefilter_cap = std::nullopt;
  return params;
}

TEST(PlainCosts, AreTheFormulaOfAbsoluteAndSquaredDifferences) {
  const dataset::StereoScene scene = random_scene(23, 9);
  for (const lab::Cost cost : {lab::Cost::kSad, lab::Cost::kSsd}) {
    for (const auto& [width, height] : {std::pair(1, 1), std::pair(4, 3), std::pair(5, 8)}) {
      const lab::MatchParams params = params_of(cost, width, height);
      PlainCosts<std::uint32_t> rows(scene, params);
      for (int y = 0; y < rows.height(); ++y) {
        const std::span<const std::uint32_t> row = rows.row(y);
        for (int x = 0; x < rows.width(); ++x) {
          for (int d = 0; d < rows.lanes(); ++d) {
            const std::uint32_t expected = d < params.disparities && d <= x
                                               ? block_difference(scene, params, x, y, d)
                                               : dsp::kNoCost<std::uint32_t>;
            ASSERT_EQ(row[static_cast<std::size_t>(x * rows.lanes() + d)], expected)
                << x << ", " << y << ", " << d;
          }
        }
      }
    }
  }
}

template <typename Sum>
void expect_the_appliances_rows(const dataset::StereoScene& scene, const lab::MatchParams& params) {
  const int width = scene.left.width;
  const int height = scene.left.height;
  Workspace workspace(dsp::bytes_taken([&](dsp::Arena& measure) {
    dsp::PreparedPair(params, width, height, measure);
    lab::CostRows(params, width, measure);
  }));
  dsp::Arena arena = workspace.arena();
  dsp::PreparedPair pair(params, width, height, arena);
  lab::CostRows appliance(params, width, arena);
  pair.start(scene.left.view(), scene.right.view());
  pair.filter({0, height});
  pair.derive({0, height});
  dsp::CostPictures pictures;
  pictures.left = pair.left();
  pictures.right = pair.right();
  appliance.start(pictures);
  PlainCosts<Sum> plain(scene, params);
  for (int y = 0; y < height; ++y) {
    ASSERT_TRUE(std::ranges::equal(plain.row(y), appliance.row<Sum>(y))) << "row " << y;
  }
}

TEST(PlainCosts, AreThoseOfTheApplianceForEveryCost) {
  const dataset::StereoScene scene = random_scene(31, 11);
  for (const lab::Cost cost :
       {lab::Cost::kSad, lab::Cost::kSsd, lab::Cost::kCensus5x5, lab::Cost::kCensus9x7}) {
    for (const bool derivative : {false, true}) {
      SCOPED_TRACE(testing::Message() << "cost " << static_cast<int>(cost) << " " << derivative);
      lab::MatchParams params = params_of(cost, 5, 4);
      params.prefilter_cap = derivative ? std::optional(15) : std::nullopt;
      if (lab::CostRows::wide(params)) {
        expect_the_appliances_rows<std::uint32_t>(scene, params);
      } else {
        expect_the_appliances_rows<std::uint16_t>(scene, params);
      }
    }
  }
}

}  // namespace
}  // namespace stof::host
