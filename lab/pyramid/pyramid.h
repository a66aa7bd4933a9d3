#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "lab/dsp_names.h"
#include "lab/match_params.h"
#include "lab/pyramid/patch_candidates.h"
#include "lab/pyramid/patch_search.h"
#include "lab/pyramid/patch_strips.h"

namespace stof::lab {

// A pair of equal size, as costs compare it and as coarser sizes are made from it.
struct PyramidPictures {
  ImageView<const std::uint8_t> left;  // the derivative with a prefilter_cap, else the grey values
  ImageView<const std::uint8_t> right;
  ImageView<const std::uint8_t> left_grey;
  ImageView<const std::uint8_t> right_grey;
};

// out(x, y) = the rounded mean of in(2 x .. 2 x + 1, 2 y .. 2 y + 1); borders replicate. Sizes
// halve, rounded up.
void halve(ImageView<const std::uint8_t> in, ImageView<std::uint8_t> out) noexcept;

// Winner takes all on sums of absolute differences, coarse to fine: all candidates at the coarsest
// of params.pyramid_levels halved sizes; at each finer size a patch (patch_search.h) searches only
// around what its surroundings found before. A thing that the coarse pictures do not show is not
// found.
// With a prefilter and blocks of at least 8 px either way, neighbours having most of their block in
// common, only every second pixel of every second row is searched, and those between take a winner
// of their neighbours (pyramid_rows.h), first along rows. Where right winners are wanted each pixel
// of the finest size is searched.
// Source: Sun 2002.
class CoarseToFine {
 public:
  // For pictures of exactly this size. params: block, disparities, prefilter_cap and
  // pyramid_levels count. check: right winners are wanted.
  CoarseToFine(const MatchParams& params, bool check, int width, int height, Arena& arena) noexcept;

  // winners: of the pictures' size; right empty where it is not wanted.
  void match(const PyramidPictures& pictures, const PatchWinners& winners) noexcept;

 private:
  // One size of the pair, how it is searched, and what was found in it.
  struct Level {
    MatchParams params;
    PyramidPictures pictures;
    PatchWinners winners;
    int step = 1;  // of every so many pixels and rows there are winners
    // Pictures of a coarser level.
    ImageView<std::uint8_t> left_grey;
    ImageView<std::uint8_t> right_grey;
    ImageView<std::uint8_t> left;  // derivatives
    ImageView<std::uint8_t> right;
    ImageView<std::int16_t> found;      // what `winners` is where nobody wants it elsewhere
    std::optional<PatchStrips> strips;  // one of these three
    std::optional<PatchSearch<std::uint16_t>> patches;
    std::optional<PatchSearch<std::uint32_t>> wide_patches;
    std::span<CandidateRange> ranges;
  };

  static void take_search(Level& level, bool coarsest, bool check, int width, int height,
                          Arena& arena) noexcept;
  static void halve_into(const Level& fine, Level& coarse) noexcept;
  static CoarseWinners found(const Level& level) noexcept;
  static CandidateList candidates(const Level& level, const Level* coarse, int x,
                                  Rows rows) noexcept;
  static void search_strips(Level& level, const Level* coarse) noexcept;
  template <typename Sum>
  static void search(Level& level, PatchSearch<Sum>& patches, const Level* coarse) noexcept;

  static constexpr int kMostLevels = 2;

  std::array<Level, kMostLevels + 1> levels_;
  int count_;  // of levels, the finest first
};

}  // namespace stof::lab
