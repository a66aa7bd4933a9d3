#pragma once

#include <optional>

#include "dataset/dataset.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"

namespace stof::host {

// How good a disparity map of the left view is. Every share is in 0..1 and absent where it has no
// pixels to count, or where the scene has no truth or no mask for it.
//
// A pixel with truth is bad when it is missing or |d - truth| > 1 px. The signed variant, the
// chapter's eq. 5 as printed, counts d - truth > 1 instead; missing stays bad.
struct DisparityScore {
  std::optional<double> all;      // bad share of the pixels with truth
  std::optional<double> visible;  // ... of those the scene's mask calls not occluded
  std::optional<double> core;  // ... of those with x >= ndisp + w/2 and w/2 from the other borders
  std::optional<double> of_valid;        // ... of the pixels with truth and a disparity
  std::optional<double> signed_all;      // as all, signed
  std::optional<double> signed_visible;  // as visible, signed
  std::optional<double> near_edges;      // as visible, of those at near_discontinuities()
  double density = 0;                    // share of all pixels of the image that have a disparity
};

// disparity: px, +inf = none, of the scene's size. block_width: the w of `core`.
DisparityScore score_disparity(const dataset::Image<float>& disparity,
                               const dataset::StereoScene& scene, int block_width);

// The mean of each number over the scores that have it. An empty span gives an empty score.
DisparityScore mean_score(std::span<const DisparityScore> scores);

// 255 where, within kNearEdgePx rows and columns, the truth of two neighbours (side by side or one
// above the other, both known) differs by more than kEdgeStepPx; else 0.
inline constexpr int kNearEdgePx = 9;
inline constexpr float kEdgeStepPx = 2;
dataset::Image<std::uint8_t> near_discontinuities(const dataset::Image<float>& truth);

// Pixels, +inf = none.
dataset::Image<float> to_pixels(dsp::ImageView<const dsp::Disparity> disparity);

}  // namespace stof::host
