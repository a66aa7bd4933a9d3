#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/stereo/cost/mask_costs.h"
#include "dsp/stereo/match_params.h"
#include "dsp/stereo/prepared_pair.h"
#include "dsp/stereo/row_search.h"

namespace stof::dsp {

// In place of a peak ratio that was not computed: neither distinct nor with rivals.
inline constexpr std::uint8_t kRatioUnknown = 128;

// Matches one stereo pair as MatchParams say: picture, cost, search, checks, refinement. Holds its
// buffers, allocates nothing. Disparities in the left image, none where no candidate lies inside
// the right image, where all of them cost the same (a flat, black or saturated picture) or where a
// check failed. Nothing is filled unless asked for, and filled() tells what was.
class Matcher {
 public:
  // Bytes of the Arena that a Matcher for images up to width x height takes.
  static std::size_t bytes_needed(const MatchParams& params, int width, int height) noexcept;

  // params, width and height must pass check().
  Matcher(const MatchParams& params, int width, int height, Arena& arena) noexcept;

  // left, right, out: equal size, at most the constructor's. Any size from 1x1; empty does nothing.
  // guide: of the same size, or empty; not empty only where MatchParams are `guided`. The result is
  // that of a search in which what the guide leaves out costs kNoCost (mask_costs(), of costs
  // before and of sums after any paths) and no pixel takes a candidate outside of its range: a
  // pixel whose costs have no minimum inside has no disparity. A range of one candidate that ties
  // with its neighbours is none either. Only distinctness looks at the costs of all candidates: a
  // flat surface is as flat within a range. Median and fill come after it and know no ranges.
  void match(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
             ImageView<Disparity> out, Guide guide = {}) noexcept;

  // match() in steps, for splitting: each step over all rows, in any split, before the next. The
  // result of a row does not depend on the split. Pictures and guide are looked at until finish().
  void start(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
             Guide guide = {}) noexcept;
  void filter(Rows rows) noexcept;
  void derive(Rows rows) noexcept;
  void match_rows(Rows rows, ImageView<Disparity> out) noexcept;
  void finish(ImageView<Disparity> out) noexcept;  // what looks at the whole map

  // With MatchParams::confidence, of the last match(); else empty.
  // Peak ratio of each pixel (check/peak_ratio.h): 0 = nothing comes near, 255 = a rival is as
  // good; kRatioUnknown from searches of whole maps, which keep no costs. Means nothing where there
  // is no disparity.
  ImageView<const std::uint8_t> ratio() const noexcept;
  // Disparities that were consistent, but were dropped because they did not stand out (distinct,
  // min_texture): right where another sensor agrees. None elsewhere.
  ImageView<const Disparity> weak() const noexcept;

  // 1 for each pixel of the last match() whose disparity was made up, by MatchParams::fill or as
  // the background of an occlusion (kOrdered); else 0. Empty where neither can be.
  ImageView<const std::uint8_t> filled() const noexcept;

 private:
  template <typename Sum>
  void match_rows_with(RowSearch<Sum>& search, Rows rows, ImageView<Disparity> out) noexcept;
  template <typename Sum>
  void check_row(const FoundRow<Sum>& found, int y) noexcept;
  template <typename Sum>
  void judge_distinctness(const FoundRow<Sum>& found, int y) noexcept;
  template <typename Sum>
  void refine_row(const FoundRow<Sum>& found, int y, std::span<Disparity> out) noexcept;
  void fit_grey_values(int y, std::span<Disparity> out) noexcept;
  void match_map(ImageView<Disparity> out) noexcept;
  void drop_implausible(ImageView<Disparity> out) noexcept;
  void keep_weak(ImageView<const Disparity> out) noexcept;

  MatchParams params_;
  PreparedPair pair_;
  std::optional<RowSearch<std::uint16_t>> search_;
  std::optional<RowSearch<std::uint32_t>> wide_search_;
  ImageView<std::int16_t> margins_;  // distinct
  ImageView<Disparity> spare_;       // the map before a check or the median
  ImageView<std::uint8_t> filled_;
  ImageView<std::uint8_t> ratio_;
  ImageView<Disparity> weak_;
  std::span<std::byte> scratch_;  // of one check or one whole-map search at a time
  int width_ = 0;                 // of the current pictures
  int height_ = 0;
};

}  // namespace stof::dsp
