#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/calib/calibration.h"
#include "dsp/fusion/project/reproject.h"
#include "dsp/pmd/converter.h"
#include "dsp/stereo/cost/candidate_mask.h"

namespace stof::dsp {

// When a PMD reading may narrow the stereo search, and by how much. The search must keep room to
// contradict: stereo that can only repeat what the PMD says is no second witness.
struct GuideParams {
  // A range reaches this share of Z beyond the PMD interval. Noise does not explain all: light on
  // two ways, wiggling, stray light and a line that does not fit are 1 to 5 percent of the distance
  // (Kuhnert & Stommel 2006, sections 3.2 and 6: 3 to 5), a turn of the head by 1 degree on a wall
  // seen at 45 degrees is 2.
  double margin = 0.07;
  // Before that it reaches so many sigma to either side of the reading, where the PMD interval (2
  // beyond the nearest and the farthest reading around the pixel) does not.
  double sigmas = 4;
  // Readings whose sigma is a larger share of the distance say nothing: with the margin, 4 sigma of
  // them would be more than a quarter of Z to either side, which narrows a usual search by little.
  double most_sigma = 0.05;
  // Readings repeat after PmdMaps::range. Nothing that sends light back lies beyond this, metres;
  // a reading that may as well lie one turn further, and still within it, limits the near side
  // only. 0: every reading has the wrap count it claims.
  double farthest_m = 0;
  // All that readings within so many px of a pixel say counts for it, 0 to 32: places in the left
  // view are known to a few px (0.1 degree of a rig's turn is 1.7 px at a focal length of 1000 px),
  // and where the PMD says nothing that near, it says nothing here too.
  int reach = 4;
};

// The PMD's intervals as a guide for the Matcher: which candidates each left pixel may match. It
// says nothing (all candidates) about a pixel
//   - where no reading lies, or one that has kPmdEdge or a large sigma
//   - where a thing that the PMD could not measure may stand before what it did: places along the
//     rays of its missing pixels, as far as stereo could match something there
//   - less than `reach` px from such a pixel, or from a step in depth
// Holds its buffers, allocates nothing after construction. Integers but for the projection; the
// same bits everywhere.
class GuideMaker {
 public:
  // Depth to candidate needs one relation for all columns: false for rigs of converging axes, and
  // without a PMD.
  static bool serves(const Calibration& calibration) noexcept;

  // calibration: complete(), serves(). Stereo size width x height, candidates as of MatchParams.
  GuideMaker(const Calibration& calibration, const GuideParams& params, int min_disparity,
             int disparities, int width, int height, Arena& arena) noexcept;

  // maps: of the calibration's sensor. Valid until the next call; of the stereo size.
  Guide make(const PmdMaps& maps) noexcept;

 private:
  // Readings at PMD resolution as the Reprojector takes them.
  struct Readings {
    ImageView<QuarterMm> distance;
    ImageView<QuarterMm> low;
    ImageView<QuarterMm> high;
    ImageView<std::uint8_t> flags;
    PmdMaps maps() const noexcept;
  };
  void judge_row(const PmdMaps& maps, int y) const noexcept;
  bool find_hidden(const PmdMaps& maps) const noexcept;
  void open_before_missing() noexcept;
  void spread_along_row(int y) noexcept;
  void write_row(int y) noexcept;

  int reach_ = 0;
  std::uint32_t sigmas_q8_ = 0;
  std::uint32_t most_sigma_q16_ = 0;  // of the distance
  std::uint32_t farthest_ = 0;        // quarter mm; 0: no wrap count is in doubt
  std::span<QuarterMm> steps_;        // distances that stand for all at which stereo could match
  Reprojector reprojector_;
  Readings readings_;
  SplattedView view_;
  ImageView<QuarterMm> spread_high_;  // along rows; spread low ends in view_.nearest
  ImageView<Candidates> guide_;
  std::span<std::int16_t> first_of_;  // by depth (guide_tables.h)
  std::span<std::int16_t> last_of_;
  std::span<QuarterMm> row_low_;
  std::span<QuarterMm> row_high_;
};

}  // namespace stof::dsp
