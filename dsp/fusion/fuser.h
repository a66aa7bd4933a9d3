#pragma once

#include <cstddef>
#include <cstdint>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/calib/calibration.h"
#include "dsp/pmd/converter.h"

namespace stof::dsp {

// Where a fused depth comes from. Values travel on the wire.
enum class Source : std::uint8_t {
  kNone = 0,
  kStereo = 1,
  kPmd = 2,
  kBoth = 3,
  kResolved = 4,  // the sensors disagreed, one was clearly better supported
  kConflict = 5,  // the sensors disagreed: no depth
};

inline constexpr std::int16_t kMaxStereoSigma = 1024;  // 64 px

struct FusionParams {
  QuarterMm max_range = 40000;    // a missing sensor's interval is [0, max_range]; 10 m
  std::int16_t stereo_sigma = 8;  // sigma_d in 1/16 px, 0 .. kMaxStereoSigma
};

// Depth map in the left picture; Z in the axes that StereoRig describes, those of the rectified
// left camera. All images have the stereo size.
// depth is the middle of [depth - width / 2, depth + width / 2], the published interval (+-2
// sigma).
struct DepthMap {
  ImageView<QuarterMm> depth;  // Z; 0 = none
  ImageView<QuarterMm> width;  // hi - lo; 0 where depth is none
  ImageView<Source> source;
};

// Carries the PMD intervals into the left camera and intersects them with the stereo intervals,
// which come from the disparity alone, or from both columns where the rig's axes converge.
class Fuser {
 public:
  // disparities: of the Matcher whose result will be fused.
  static std::size_t bytes_needed(int width, int height, int disparities, int pmd_width,
                                  int pmd_height) noexcept;

  // stereo size width x height; the calibration is complete(), its PMD size may be 0x0 (stereo
  // only).
  Fuser(const Calibration& calibration, const FusionParams& params, int min_disparity,
        int disparities, int width, int height, Arena& arena) noexcept;

  // pmd: nullptr for stereo only; disparity: an empty view for PMD only. out: all three written.
  void fuse(ImageView<const Disparity> disparity, const PmdMaps* pmd, const DepthMap& out) noexcept;

 private:
  struct Tables;
  Tables* tables_;
};

}  // namespace stof::dsp
