#pragma once

#include <cstddef>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/calib/calibration.h"
#include "dsp/fusion/fuser.h"
#include "dsp/pmd/pmd_maps.h"

namespace stof::dsp {

// Tells how often a PMD reading wrapped. A sensor of one frequency repeats after pmd.range (R, 7.49
// m at 20 MHz): a reading d is a surface at d, d + R, d + 2 R, ... The candidates are those whose Z
// from the left camera is at most max_range and that u16 holds; what lies beyond is a rival that
// can refute them, never a result. A wrap count is decided where
//   its amplitude leaves only wrap count 0: no surface returns more than 1.5 times what a white one
//     does (PmdSensor::white_lsb / r^2), so a bright reading cannot come from further away; or
//   stereo supports it: five eighths of the disparities around the place where the reading would
//     lie in the left view agree with its distance, while for no rival a quarter does; most of the
//     surface around it says the same (readings without a disparity take what their surface says),
//     and so do half as many again of the decided readings nearby as speak for any rival; or
//   its region is proven: readings that go on within their noise, in distance (also across the
//     wrap) and in amplitude, from some that are bright; or
//   nothing else is possible: only wrap count 0 lies within max_range, and neither stereo nor its
//     region speaks for another; or
//   white_lsb is unknown, and wrapped once it would be four times as bright as all but the
//     brightest of what was decided in this picture. Where nothing was, it has not wrapped.
// Any other is kPmdWrapped. So is one at whose place a quarter of the disparities lie further than
// pmd.widest (R / 2) from it, or that ends beside an unknown one: it may be mixed from surfaces
// that far apart, and so lie anywhere.
class Unwrapper {
 public:
  // Whether a reading of this sensor has more than one candidate; else there is nothing to do.
  static bool needed(const PmdSensor& sensor, const FusionParams& params) noexcept;

  // Stereo size width x height, as the Fuser's. remembers: wrap counts of earlier frames count, too
  // (decision/wrap_memory.h), until forget_past().
  Unwrapper(const Calibration& calibration, const FusionParams& params, int min_disparity,
            int disparities, int width, int height, Arena& arena, bool remembers = false) noexcept;

  // pmd: of PmdConverter::measure(). Adds range times wrap count to distance, or sets kPmdWrapped
  // and distance = sigma = 0; then low, high and the flags that come from neighbours
  // (refresh_intervals()). disparity: of the same moment, left size, or empty: then amplitude alone
  // decides.
  void resolve(const PmdMaps& pmd, ImageView<const Disparity> disparity) noexcept;
  void forget_past() noexcept;

 private:
  struct Parts;
  Parts* parts_;
};

}  // namespace stof::dsp
