#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/base/thread_team.h"
#include "dsp/stereo/cost/mask_costs.h"
#include "dsp/stereo/match_params.h"
#include "dsp/stereo/prepared_pair.h"
#include "dsp/stereo/row_search.h"

namespace stof::dsp {

// In place of a peak ratio that was not computed: neither distinct nor with rivals.
inline constexpr std::uint8_t kRatioUnknown = 128;

// Rows that a thread does at once, where a step looks at few others.
inline constexpr int kRowsAtOnce = 16;

// Matches one stereo pair as MatchParams say: picture, cost, search, checks, refinement. Holds its
// buffers, allocates nothing. Disparities in the left image, none where no candidate lies inside
// the right image, where all of them cost the same (a flat, black or saturated picture) or where a
// check failed. Nothing is filled unless asked for, and filled() tells what was.
class Matcher {
 public:
  // Bytes of the Arena that a Matcher for images up to width x height takes, with a crew of so many
  // threads: each has a search of its own.
  static std::size_t bytes_needed(const MatchParams& params, int width, int height,
                                  int threads = 1) noexcept;

  // params, width and height must pass check(). The result is the same with any crew; searches of
  // whole maps have but one thread.
  Matcher(const MatchParams& params, int width, int height, Arena& arena,
          const Crew& crew = {}) noexcept;

  // left, right, out: equal size, at most the constructor's. Any size from 1x1; empty does nothing.
  // guide: of the same size, or empty; not empty only where MatchParams are `guided`. The result is
  // that of a search in which what the guide leaves out costs kNoCost (mask_costs(), of costs
  // before and of sums after any paths) and no pixel takes a candidate outside of its range: a
  // pixel whose costs have no minimum inside has no disparity. A range of one candidate that ties
  // with its neighbours is none either. Only distinctness looks at the costs of all candidates: a
  // flat surface is as flat within a range. Median and fill come after it and know no ranges.
  void match(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
             ImageView<Disparity> out, Guide guide = {}) noexcept;

  // match() in steps. Pictures and guide are looked at until finish().
  void start(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
             Guide guide = {}) noexcept;
  void search(ImageView<Disparity> out) noexcept;  // what looks at rows, by the crew
  void finish(ImageView<Disparity> out) noexcept;  // what looks at the whole map

  // search() in steps: each over all rows, in any split, before the next. The result of a row does
  // not depend on the split. thread: below that of the crew; one at a time each.
  void filter(Rows rows) noexcept;
  void derive(Rows rows) noexcept;
  void match_rows(Rows rows, ImageView<Disparity> out, int thread = 0) noexcept;

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
  void match_rows_with(RowSearch<Sum>& search, Rows rows, int thread,
                       ImageView<Disparity> out) noexcept;
  template <typename Sum>
  void check_row(const FoundRow<Sum>& found, int y, int thread) noexcept;
  template <typename Sum>
  void judge_distinctness(const FoundRow<Sum>& found, int y) noexcept;
  template <typename Sum>
  void refine_row(const FoundRow<Sum>& found, int y, std::span<Disparity> out) noexcept;
  void fit_grey_values(int y, std::span<Disparity> out) noexcept;
  void match_map(ImageView<Disparity> out) noexcept;
  void drop_implausible(ImageView<Disparity> out) noexcept;
  void drop_specks(ImageView<Disparity> out) noexcept;
  void keep_weak(ImageView<const Disparity> out) noexcept;
  void note_filled(ImageView<Disparity> out) noexcept;
  std::span<std::byte> scratch_of(int thread) const noexcept;
  template <typename Job>
  void by_rows(Job&& job) const noexcept;

  MatchParams params_;
  Crew crew_;
  PreparedPair pair_;
  std::span<RowSearch<std::uint16_t>> searches_;  // one for each thread, or wide ones
  std::span<RowSearch<std::uint32_t>> wide_searches_;
  ImageView<std::int16_t> margins_;  // distinct
  ImageView<Disparity> spare_;       // the map before a check or the median
  ImageView<std::uint8_t> filled_;
  ImageView<std::uint8_t> ratio_;
  ImageView<Disparity> weak_;
  std::span<std::byte> scratch_;  // of one whole-map step at a time, or shared out to the threads,
  std::size_t thread_bytes_;      // so much each,
  std::size_t map_bytes_;         // or so much for each of two maps
  int width_ = 0;                 // of the current pictures
  int height_ = 0;
};

// job(Rows, thread) for all rows, by the crew.
template <typename Job>
void Matcher::by_rows(Job&& job) const noexcept {
  crew_.run_rows({0, height_}, kRowsAtOnce, job);
}

}  // namespace stof::dsp
