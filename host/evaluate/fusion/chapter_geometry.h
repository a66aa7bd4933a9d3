#pragma once

#include "dsp/base/image.h"
#include "dsp/calib/calibration.h"
#include "dsp/fusion/depth_map.h"
#include "dsp/fusion/project/splat.h"
#include "dsp/pmd/pmd_maps.h"

// The rule of Kuhnert & Stommel 2006, section 4.1, to see what the rest of the fusion gains. For
// comparison alone; the appliance has nothing of it.
namespace stof::host {

// The PMD map enlarged by a factor until it fits the left picture: the pixel (x, y) of the left
// view takes the PMD pixel nearest to
//   ((x - c_s) f_p / f_s + c_p, and the same of y),
// c the principal points, f the focal lengths of the left camera (s) and of the PMD camera (p).
// Neither the rotation nor the translation between the cameras nor lens distortion counts, so
// matches are shifted by tens of pixels; and the radial distance is taken for depth. Pixels beside
// the PMD's picture and those without a distance get nothing splatted. Writes all of `view`
// (splat.h; nearest holds the distance).
void splat_by_scaling(const dsp::PmdMaps& maps, const dsp::Calibration& calibration,
                      const dsp::SplattedView& view);

// The same readings where they belong: by the appliance's own reprojection.
void splat_by_geometry(const dsp::PmdMaps& maps, const dsp::Calibration& calibration,
                       const dsp::SplattedView& view);

// The interval rule alone (intersect.h), nothing resolved afterwards. stereo: as published by a
// Fuser without PMD; ratio: peak ratio of its matches; empty `ratio`: no stereo at all. All images
// have the left view's size and all of `out` is written.
void fuse_by_interval(const dsp::DepthMap& stereo, dsp::ImageView<const std::uint8_t> ratio,
                      const dsp::SplattedView& splatted, dsp::QuarterMm max_range,
                      const dsp::DepthMap& out);

}  // namespace stof::host
