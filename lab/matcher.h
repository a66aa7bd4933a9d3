#pragma once

#include <cstdint>
#include <optional>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "dsp/base/thread_team.h"
#include "dsp/stereo/matcher.h"
#include "lab/dsp_names.h"
#include "lab/fill.h"
#include "lab/match_params.h"
#include "lab/searches.h"

namespace stof::lab {

// The appliance's Matcher, with the lab's searches where it has none of its own, and holes filled
// where that is asked for: matches that the checks found weak come back, the rest is filled
// (fill.h), and what came out is smoothed twice (weighted_median.h).
class Matcher {
 public:
  // params, width and height pass check(). The result is the same with any team. Searches of whole
  // maps take pictures of exactly this size, all others smaller ones too.
  Matcher(const MatchParams& params, int width, int height, Arena& arena,
          const ThreadTeam& team = {}) noexcept;

  void match(const MatchInput& input, ImageView<Disparity> out) noexcept;

  ImageView<const std::uint8_t> ratio() const noexcept { return matcher_.ratio(); }
  ImageView<const Disparity> weak() const noexcept { return matcher_.weak(); }
  // 1 for each pixel of the last match() whose disparity was made up, by MatchParams::fill or as
  // the background of an occlusion (kDynamicProgramming); else 0. Empty where neither can be.
  ImageView<const std::uint8_t> filled() const noexcept { return cut(filled_, width_, height_); }

 private:
  void make_dense(ImageView<const std::uint8_t> grey, ImageView<Disparity> out,
                  ImageView<std::uint8_t> filled) noexcept;

  std::optional<Filler> filler_;
  ImageView<Disparity> copy_;  // of the map that is smoothed
  bool continues_;             // kDynamicProgramming
  ImageView<std::uint8_t> filled_;
  Searches searches_;
  dsp::Matcher matcher_;
  int width_ = 0;  // of the current pictures
  int height_ = 0;
};

}  // namespace stof::lab
