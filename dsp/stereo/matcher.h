#pragma once

#include <array>
#include <cstdint>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/base/thread_team.h"
#include "dsp/stereo/cost/candidate_mask.h"
#include "dsp/stereo/match_params.h"
#include "dsp/stereo/prepared_pair.h"
#include "dsp/stereo/rectify/rectifier.h"
#include "dsp/stereo/row_search.h"
#include "dsp/stereo/validation/map_checks.h"

namespace stof::dsp {

// The input of a Matcher, valid until match() returns. All of one size, at most the constructor's;
// any from 1x1.
struct MatchInput {
  ImageView<const std::uint8_t> left;
  ImageView<const std::uint8_t> right;
  // Empty, but where MatchParams are `guided`. The result is that of a search in which what the
  // guide leaves out costs kNoCost (mask_candidates(), of costs before and of sums after any paths)
  // and no pixel takes a candidate outside of its range: a pixel whose costs have no minimum inside
  // has no disparity. A range of one candidate that ties with its neighbours is none either. Only
  // distinctness looks at the costs of all candidates: a flat surface is as flat within a range.
  // The median comes after it and knows no ranges.
  Guide guide = {};
  // It made the pictures: pixels that its cameras did not see have no disparity, and no check looks
  // at any. nullptr: all were seen.
  const Rectifier* rectifier = nullptr;
};

// Matches one stereo pair as MatchParams say: picture, cost, search, checks, refinement. Holds its
// buffers, allocates nothing. Disparities in the left image, none where no candidate lies inside
// the right image, where all of them cost the same (a flat, black or saturated picture) or where a
// check failed. Nothing is filled.
class Matcher {
 public:
  // params, width and height pass check(). The result is the same with any team. maker: who makes
  // the searches; nullptr: they are those of params. Asked here alone.
  Matcher(const MatchParams& params, int width, int height, Arena& arena,
          const ThreadTeam& team = {}, SearchMaker* maker = nullptr) noexcept;

  // out: of the pictures' size.
  void match(const MatchInput& input, ImageView<Disparity> out) noexcept;

  // With MatchParams::confidence, of the last match(); else empty.
  // Peak ratio of each pixel (validation/peak_ratio.h): 0 = nothing comes near, 255 = a rival is as
  // good; kRatioUnknown from searches that keep no costs. Means nothing where there is no
  // disparity.
  ImageView<const std::uint8_t> ratio() const noexcept;
  // Disparities that were consistent, but were dropped because they did not differ enough from
  // their rivals or surroundings (distinct, min_texture): right where another sensor agrees. None
  // elsewhere.
  ImageView<const Disparity> weak() const noexcept { return checks_.weak(); }

 private:
  void prepare(const MatchInput& input) noexcept;
  void search(ImageView<Disparity> out) noexcept;
  MatchedRow row_of(int y, ImageView<Disparity> out) noexcept;

  ThreadTeam team_;
  PreparedPair pair_;
  std::array<RowSearch*, ThreadTeam::kMost> searches_{};  // one for each thread
  int rows_at_once_ = 1;
  ImageView<std::int16_t> margins_;  // distinct
  ImageView<std::uint8_t> ratio_;
  MapChecks checks_;
  int width_ = 0;  // of the current pictures
  int height_ = 0;
};

}  // namespace stof::dsp
