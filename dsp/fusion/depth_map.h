#pragma once

#include <cstdint>

#include "dsp/base/fixed.h"
#include "dsp/base/image.h"

namespace stof::dsp {

// Where a fused depth comes from. Values travel on the wire.
enum class Source : std::uint8_t {
  kNone = 0,
  kStereo = 1,
  kPmd = 2,
  kBoth = 3,
  kResolved = 4,  // one sensor could not tell or was wrong, and the other, or the surfaces around,
                  // are clearly better supported
  kConflict = 5,  // the sensors disagreed: no depth
};
inline constexpr int kSources = 6;

// Why a depth was resolved, or why there is none although a sensor saw something.
enum class Cause : std::uint8_t {
  kNone = 0,
  kMixedPixel = 1,       // the PMD pixel sees two surfaces
  kStereoAmbiguous = 2,  // the match has rivals; with kNone: nothing but the match spoke for it
  kRangeAmbiguous = 3,   // the sensors differ by about one unambiguous range of the PMD; with a
                         // depth: the surfaces around tell how often the PMD's reading wrapped
  kOccluded = 4,       // only the left camera sees the surface, or the match is of something nearer
                       // beside it; the PMD confirms the background
  kContradiction = 5,  // the PMD excludes the match, or both are sound: stray light, glass
  kInterpolated = 6,   // no sensor told it: between or behind the surfaces around
};
inline constexpr int kCauses = 7;

// Depth map in the left picture; Z in the axes that StereoRig describes, those of the rectified
// left camera. All images have the stereo size.
// depth is the middle of [depth - width / 2, depth + width / 2], the published interval (+-2
// sigma).
struct DepthMap {
  ImageView<QuarterMm> depth;  // Z; 0 = none
  ImageView<QuarterMm> width;  // hi - lo; 0 where depth is none
  ImageView<Source> source;
  ImageView<Cause> cause = {};  // may be empty
};

}  // namespace stof::dsp
