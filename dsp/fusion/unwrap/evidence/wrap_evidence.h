#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/calib/calibration.h"
#include "dsp/calib/pmd/ray_table.h"
#include "dsp/fusion/fuser.h"
#include "dsp/fusion/project/project.h"
#include "dsp/fusion/unwrap/count_votes.h"
#include "dsp/fusion/unwrap/evidence/amplitude_bound.h"
#include "dsp/fusion/unwrap/evidence/stereo_samples.h"
#include "dsp/fusion/unwrap/wrap_maps.h"
#include "dsp/pmd/pmd_maps.h"

namespace stof::dsp {

// Evidence of amplitude and stereo about every reading alone.
class WrapEvidence {
 public:
  // Fewer disparities than that around a place say nothing.
  static constexpr int kLeastKnown = 6;

  WrapEvidence(const Calibration& calibration, const FusionParams& params, int min_disparity,
               int disparities, int width, int height, Arena& arena) noexcept;

  // Fills readings, vote, possible, mixed and bright of the maps, whose range and wrap_counts are
  // set. disparity may be empty. A vote is the wrap count of which five eighths of the samples
  // around its place agree with the reading, while of no other more than a quarter do.
  void collect(const PmdMaps& pmd, ImageView<const Disparity> disparity,
               const AmplitudeBound& bound, WrapMaps& maps) noexcept;

 private:
  // Some readings of a row, as if all had the same wrap count; `distance` of all of the row.
  struct Candidates {
    std::span<QuarterMm> distance;
    std::span<std::int32_t> u;
    std::span<std::int32_t> v;
    std::span<QuarterMm> depth;
    std::span<QuarterMm> tolerance;
    std::span<Votes> votes;
    Candidates first(std::size_t n) const noexcept {
      return {distance, u.first(n), v.first(n), depth.first(n), tolerance.first(n), votes.first(n)};
    }
  };
  struct Columns {
    std::size_t begin;
    std::size_t end;
  };
  // Of a row's readings: the last wrap count that at least 5/8 of the samples support; how many
  // counts more than 1/4 support.
  struct Support {
    std::span<std::int16_t> wraps;
    std::span<std::uint16_t> comparable;
  };
  static void read_row(const PmdMaps& pmd, int y, const AmplitudeBound& bound,
                       WrapMaps& maps) noexcept;
  void place_row(const PmdMaps& pmd, int y, int k, const AmplitudeBound& bound,
                 const WrapMaps& maps) const noexcept;
  Columns next_columns(std::size_t end) const noexcept;
  void look_up(std::span<const QuarterMm> distance, const PmdMaps& pmd, int y,
               std::size_t begin) noexcept;
  void judge(int y, int k, const Columns& columns, WrapMaps& maps) const noexcept;
  void vote_row(int y, WrapMaps& maps) noexcept;

  QuarterMm max_range_;
  StereoSamples samples_;
  Projection projection_;
  RayTable rays_;
  Candidates candidates_;
  Support support_;
};

}  // namespace stof::dsp
