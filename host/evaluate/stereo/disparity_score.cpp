#include "host/evaluate/stereo/disparity_score.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/evaluate/mean_of.h"
#include "host/evaluate/share.h"

namespace stof::host {
namespace {

constexpr float kBadAbovePx = 1;

struct Shares {
  Share all;
  Share visible;
  Share core;
  Share of_valid;
  Share signed_all;
  Share signed_visible;
  Share near_edges;

  void count(float disparity, float truth, bool is_visible, bool in_core, bool at_edge) {
    const bool missing = !std::isfinite(disparity);
    const bool bad = missing || std::abs(disparity - truth) > kBadAbovePx;
    const bool signed_bad = missing || disparity - truth > kBadAbovePx;
    all.count(bad);
    signed_all.count(signed_bad);
    if (!missing) {
      of_valid.count(bad);
    }
    if (is_visible) {
      visible.count(bad);
      signed_visible.count(signed_bad);
      if (in_core) {
        core.count(bad);
      }
      if (at_edge) {
        near_edges.count(bad);
      }
    }
  }
};

// Sets what lies within kNearEdgePx of (x, y).
void mark_around(int x, int y, dataset::Image<std::uint8_t>& mask) {
  const int y_end = std::min(y + kNearEdgePx + 1, mask.height);
  const int x_begin = std::max(x - kNearEdgePx, 0);
  const int x_end = std::min(x + kNearEdgePx + 1, mask.width);
  for (int row = std::max(y - kNearEdgePx, 0); row < y_end; ++row) {
    std::fill(mask.view().row(row).begin() + x_begin, mask.view().row(row).begin() + x_end,
              std::uint8_t{255});
  }
}

}  // namespace

dataset::Image<std::uint8_t> near_discontinuities(const dataset::Image<float>& truth) {
  dataset::Image<std::uint8_t> mask(truth.width, truth.height);
  const auto step = [&truth](int x, int y, int other_x, int other_y) {
    const float a = truth.view().at(x, y);
    const float b = truth.view().at(other_x, other_y);
    return std::isfinite(a) && std::isfinite(b) && std::abs(a - b) > kEdgeStepPx;
  };
  for (int y = 0; y < truth.height; ++y) {
    for (int x = 0; x < truth.width; ++x) {
      if (x + 1 < truth.width && step(x, y, x + 1, y)) {
        mark_around(x, y, mask);
        mark_around(x + 1, y, mask);
      }
      if (y + 1 < truth.height && step(x, y, x, y + 1)) {
        mark_around(x, y, mask);
        mark_around(x, y + 1, mask);
      }
    }
  }
  return mask;
}

DisparityScore score_disparity(const dataset::Image<float>& disparity,
                               const dataset::StereoScene& scene, int block_width) {
  const int margin = block_width / 2;
  const dataset::Image<std::uint8_t> edges =
      scene.truth ? near_discontinuities(*scene.truth) : dataset::Image<std::uint8_t>();
  Shares shares;
  std::size_t valid = 0;
  for (int y = 0; y < disparity.height; ++y) {
    for (int x = 0; x < disparity.width; ++x) {
      const float d = disparity.view().at(x, y);
      valid += std::isfinite(d) ? 1U : 0U;
      if (!scene.truth || !std::isfinite(scene.truth->view().at(x, y))) {
        continue;
      }
      const bool visible = scene.visible && scene.visible->view().at(x, y) != 0;
      const bool in_core = x >= scene.ndisp + margin && x < disparity.width - margin &&
                           y >= margin && y < disparity.height - margin;
      shares.count(d, scene.truth->view().at(x, y), visible, in_core, edges.view().at(x, y) != 0);
    }
  }
  const std::size_t pixels = disparity.pixels.size();
  return {.all = shares.all.value(),
          .visible = shares.visible.value(),
          .core = shares.core.value(),
          .of_valid = shares.of_valid.value(),
          .signed_all = shares.signed_all.value(),
          .signed_visible = shares.signed_visible.value(),
          .near_edges = shares.near_edges.value(),
          .density = pixels == 0 ? 0 : static_cast<double>(valid) / static_cast<double>(pixels)};
}

DisparityScore mean_score(std::span<const DisparityScore> scores) {
  DisparityScore result{.all = mean_of(scores, &DisparityScore::all),
                        .visible = mean_of(scores, &DisparityScore::visible),
                        .core = mean_of(scores, &DisparityScore::core),
                        .of_valid = mean_of(scores, &DisparityScore::of_valid),
                        .signed_all = mean_of(scores, &DisparityScore::signed_all),
                        .signed_visible = mean_of(scores, &DisparityScore::signed_visible),
                        .near_edges = mean_of(scores, &DisparityScore::near_edges)};
  for (const DisparityScore& score : scores) {
    result.density += score.density / static_cast<double>(scores.size());
  }
  return result;
}

dataset::Image<float> to_pixels(dsp::ImageView<const dsp::Disparity> disparity) {
  dataset::Image<float> image(disparity.width(), disparity.height(),
                              std::numeric_limits<float>::infinity());
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const dsp::Disparity d = disparity.at(x, y);
      if (d.valid()) {
        image.view().at(x, y) = d.pixels();
      }
    }
  }
  return image;
}

}  // namespace stof::host
