#pragma once

#include <cstddef>
#include <cstdint>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/calib/calibration.h"
#include "dsp/fusion/depth_map.h"
#include "dsp/fusion/interval/disparity_sigma.h"
#include "dsp/fusion/sensor_intervals.h"
#include "dsp/pmd/converter.h"

namespace stof::dsp {

inline constexpr std::int16_t kMaxStereoSigma = 127;  // 1/16 px
inline constexpr std::int32_t kMaxSpeedMmS = 100'000;

struct FusionParams {
  QuarterMm max_range = 40000;  // a missing sensor's interval is [0, max_range]; 10 m
  // sigma_d in 1/16 px, 0 .. kMaxStereoSigma, of matches that come without their peak ratio
  std::int16_t stereo_sigma = 8;
  MatchTrust trust = {};  // in the others
  // No faster does the rig drive, nor does anything come towards it: where something moves, PMD
  // intervals are longer by this times the time between the exposures of both sensors. mm/s,
  // 0 .. 100000; 1.5 m/s
  std::int32_t max_speed_mm_s = 1500;

  friend bool operator==(const FusionParams&, const FusionParams&) = default;
};

// What stereo says about each pixel: Matcher's result. All images of one size, or empty.
struct StereoMaps {
  ImageView<const Disparity> disparity;      // empty: no stereo
  ImageView<const std::uint8_t> ratio = {};  // peak ratio; empty: every match is as good
  ImageView<const Disparity> weak = {};      // believed only where the PMD agrees
  // The left picture that was matched; empty: matches may reach beyond the edges of near things
  ImageView<const std::uint8_t> picture = {};
};

// Carries the PMD intervals into the left camera and intersects them with the stereo intervals,
// which come from the disparity alone, or from both columns where the rig's axes converge; then
// resolves what only one of both saw (resolve/ambiguity_resolver.h), and where both sensors are
// there, what neither could tell (resolve/hole_filler.h).
class Fuser {
 public:
  // Stereo size width x height; the calibration is complete(), its PMD size may be 0x0 (stereo
  // only). disparities: of the Matcher whose result will be fused. threads: how many fuse_rows() or
  // intervals() run at the same time.
  Fuser(const Calibration& calibration, const FusionParams& params, int min_disparity,
        int disparities, int width, int height, Arena& arena, int threads = 1) noexcept;

  // First where the PMD's readings lie, then rows of the result, in any order and by any split:
  // the same thread number (0 .. threads - 1) not twice at the same time. stereo and out as in
  // fuse(), the same for all rows. pmd_lag_us: from the middle of the pair's exposure to that of
  // the PMD's, microseconds.
  void prepare(const PmdMaps* pmd, std::int32_t pmd_lag_us = 0) noexcept;
  void fuse_rows(const StereoMaps& stereo, Rows rows, int thread, const DepthMap& out) noexcept;

  // Where fills_holes(), two steps follow, each of all rows of cells, in any order and by any
  // split.
  bool fills_holes(const StereoMaps& stereo, const DepthMap& out) const noexcept;
  Rows cell_rows() const noexcept;
  Rows map_rows(Rows cells) const noexcept;  // of the result
  void gather_surfaces(Rows cells, const DepthMap& out) noexcept;
  void fill_holes(const StereoMaps& stereo, Rows cells, const DepthMap& out) noexcept;

  // All of these. pmd: nullptr for stereo only. out: all of its images are written.
  void fuse(const StereoMaps& stereo, const PmdMaps* pmd, const DepthMap& out) noexcept;

  // What both sensors said of a row that was fused, until this thread asks again. The pair's is
  // computed anew, where it is asked for: to keep it would take 4 bytes a pixel. stereo: as long.
  SensorIntervals intervals(const StereoMaps& stereo, int y, int thread) noexcept;

 private:
  struct Tables;
  struct StereoRow;
  struct Scratch;
  static void tell(const StereoRow& row, std::size_t begin, std::size_t end) noexcept;
  static void tell_parts(LateIntervals& self, std::size_t begin, std::size_t end) noexcept;
  StereoRow stereo_row(const StereoMaps& stereo, int y, const Scratch& scratch) const noexcept;
  void fuse_row(const StereoMaps& stereo, int y, const Scratch& scratch,
                const DepthMap& out) noexcept;

  Tables* tables_;
};

}  // namespace stof::dsp
