#pragma once

#include <array>
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
#include "dsp/fusion/unwrap/evidence/returned_light.h"
#include "dsp/fusion/unwrap/evidence/stereo_samples.h"
#include "dsp/fusion/unwrap/period_maps.h"
#include "dsp/pmd/pmd_maps.h"

namespace stof::dsp {

// What amplitude and stereo say about every reading alone.
class PeriodEvidence {
 public:
  // Fewer disparities than that around a place say nothing.
  static constexpr int kLeastKnown = 6;
  // Of a reading: the last period with five eighths, and how many have more than a quarter.
  struct Support {
    std::int16_t period = kUnknownPeriod;
    std::int16_t comparable = 0;
  };

  PeriodEvidence(const Calibration& calibration, const FusionParams& params, int min_disparity,
                 int disparities, int width, int height, Arena& arena) noexcept;

  // Fills readings, vote, possible, mixed and bright of the maps, whose range and periods are
  // set. disparity may be empty. A vote is the period of which five eighths of the samples around
  // its place agree with the reading, while of no other more than a quarter do.
  void collect(const PmdMaps& pmd, ImageView<const Disparity> disparity, const ReturnedLight& light,
               PeriodMaps& maps) noexcept;

 private:
  // A row of readings, as if all had one period.
  struct Candidates {
    std::span<QuarterMm> distance;
    std::span<std::int32_t> u;
    std::span<std::int32_t> v;
    std::span<QuarterMm> depth;
    std::span<QuarterMm> tolerance;
    std::span<Votes> votes;
  };
  static void read_row(const PmdMaps& pmd, int y, const ReturnedLight& light,
                       PeriodMaps& maps) noexcept;
  void place_row(int y, QuarterMm far_off, const ReturnedLight& light, PeriodMaps& maps) noexcept;
  void judge_row(int y, PeriodMaps& maps) noexcept;
  static void mark_periods(const Candidates& c, int k, QuarterMm max_range,
                           std::span<std::uint16_t> possible,
                           std::span<std::uint16_t> mixed) noexcept;

  QuarterMm max_range_;
  StereoSamples samples_;
  Projection projection_;
  RayTable rays_;
  std::array<Candidates, kMostPeriods> candidates_;
  std::span<Support> support_;  // of a row
};

}  // namespace stof::dsp
