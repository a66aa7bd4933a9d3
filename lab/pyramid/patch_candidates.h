#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/image.h"
#include "lab/dsp_names.h"
#include "lab/match_params.h"
#include "lab/pyramid/patch_search.h"

namespace stof::lab {

// The winners at half the size of the pictures that are searched now.
struct CoarseWinners {
  ImageView<const std::int16_t> winners;  // of every `step`-th pixel of every `step`-th row
  int step = 1;
  int min_disparity = 0;
  int disparities = 1;
};

struct CandidateList {
  std::array<std::int16_t, kMaxDisparities> numbers{};
  std::size_t count = 0;

  std::span<const std::int16_t> view() const noexcept { return std::span(numbers).first(count); }
  // first .. last, as far as they are above those before.
  void append(int first, int last) noexcept;
};

// The candidates of a patch, kPatchColumns wide from column x on: those around what its
// surroundings found at half the size, alone or as one range with all of them; everything where the
// surroundings found nothing. fine: the search of the patch.
CandidateList list_around(const CoarseWinners& coarse, const MatchParams& fine, int x,
                          Rows rows) noexcept;
CandidateRange range_around(const CoarseWinners& coarse, const MatchParams& fine, int x,
                            Rows rows) noexcept;

}  // namespace stof::lab
