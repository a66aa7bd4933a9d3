#pragma once

#include <array>
#include <string>
#include <vector>

#include "host/evaluate/fusion/fusion_case.h"
#include "host/picture/colour_scale.h"
#include "host/picture/disparity_picture.h"
#include "host/report/page/page.h"

// Pictures of one fused scene. Depths of one scene have the same colours in all of them.
namespace stof::host {

// As docs/WIRE.md explains the causes.
inline constexpr std::array<const char*, dsp::kCauses> kCauseMeanings{
    "no disagreement",
    "the PMD pixel sees two surfaces",
    "the match has rivals",
    "one unambiguous range of the PMD apart",
    "only the left camera sees it",
    "contradiction: the PMD excludes the match, or both are sound",
    "interpolated: no sensor told it, the surfaces around did"};

// How a scene is drawn.
struct FusionScales {
  ColourScale depth;         // the range of the truth
  DisparityScale disparity;  // the same as heights of 2.5D views
};
FusionScales scales_of(const FusionCase& fused);

// Figures that do not depend on the PMD camera: left picture, truth, stereo alone, its errors.
std::vector<Figure> stereo_figures(const FusionCase& fused);
// PMD alone, fused, errors of both, sources, causes, where the interval holds the truth.
std::vector<Figure> fused_figures(const FusionCase& fused);

// 2.5D views of the truth and of stereo alone; of the PMD alone and of both.
std::vector<Figure> stereo_height_fields(const FusionCase& fused);
std::vector<Figure> fused_height_fields(const FusionCase& fused);

}  // namespace stof::host
