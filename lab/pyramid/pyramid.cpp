#include "lab/pyramid/pyramid.h"

#include <algorithm>

#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "dsp/base/target.h"
#include "dsp/stereo/cost/sad.h"
#include "dsp/stereo/prefilter/prefilter.h"
#include "dsp/stereo/search/winner.h"
#include "lab/pyramid/patch_candidates.h"
#include "lab/pyramid/patch_strips.h"
#include "lab/pyramid/pyramid_rows.h"
#include "lab/search/energy.h"

namespace stof::lab {
namespace {

constexpr int kLeastQuarterBlock = 8;  // px, either side

constexpr int halved(int size) noexcept { return (size + 1) / 2; }
constexpr int floor_half(int value) noexcept { return value >= 0 ? value / 2 : -((1 - value) / 2); }
static_assert(floor_half(-3) == -2 && floor_half(-4) == -2 && floor_half(3) == 1);

// The same search at half the size.
MatchParams coarser(MatchParams params) noexcept {
  const int last = params.min_disparity + params.disparities - 1;
  params.min_disparity = floor_half(params.min_disparity);
  params.disparities = floor_half(last + 1) - params.min_disparity + 1;
  return params;
}

bool wide(const MatchParams& params) noexcept {
  return !sums_fit_u16(params.block_width, params.block_height, largest_difference(params));
}

int levels(const MatchParams& params) noexcept { return params.pyramid_levels.value_or(0); }

// Neighbouring blocks have nearly all of their pixels in common: every second one tells enough.
bool by_quarter(const MatchParams& params, bool check) noexcept {
  return !check && levels(params) > 0 && PatchStrips::serves(params) &&
         std::min(params.block_width, params.block_height) >= kLeastQuarterBlock;
}

// Strips are for few candidates, so not for the coarsest size.
bool by_strips(const MatchParams& params, bool coarsest) noexcept {
  return !coarsest && PatchStrips::serves(params);
}

static_assert(PatchSearch<std::uint16_t>::kPatchWidth == kPatchColumns);

// A row of winners from those of every second column.
void spread(const MatchParams& params, std::span<const std::int16_t> found,
            std::span<std::int16_t> out) noexcept {
  best::spread_row(found, out);
  // What its neighbour meets may lie beyond the right picture for the column between.
  const int width = static_cast<int>(out.size());
  const auto drop_outside = [&](int begin, int end) noexcept {
    for (int x = std::max(begin, 0); x < std::min(end, width); ++x) {
      std::int16_t& winner = out[static_cast<std::size_t>(x)];
      const int met = x - params.min_disparity - winner;
      winner = met < 0 || met >= width ? kNoWinner : winner;
    }
  };
  drop_outside(0, params.min_disparity + params.disparities);
  drop_outside(width + params.min_disparity, width);
}

void spread(const MatchParams& params, ImageView<const std::int16_t> found,
            ImageView<std::int16_t> out) noexcept {
  for (int r = 0; r < found.height(); ++r) {
    spread(params, found.row(r), out.row(2 * r));
    if (r > 0) {
      best::between_rows(out.row(2 * r - 2), out.row(2 * r), out.row(2 * r - 1));
    }
  }
  if (out.height() % 2 == 0) {
    std::ranges::copy(out.row(out.height() - 2), out.row(out.height() - 1).begin());
  }
}

}  // namespace

void halve(ImageView<const std::uint8_t> in, ImageView<std::uint8_t> out) noexcept {
  STOF_CHECK(out.width() == halved(in.width()) && out.height() == halved(in.height()));
  for (int y = 0; y < out.height(); ++y) {
    best::halve_row(in.row(2 * y), in.row_clamped(2 * y + 1), out.row(y));
  }
}

CoarseToFine::CoarseToFine(const MatchParams& params, bool check, int width, int height,
                           Arena& arena) noexcept
    : count_(levels(params) + 1) {
  STOF_CHECK(levels(params) <= kMostLevels);
  MatchParams at = params;
  for (int k = 0; k < count_; ++k) {
    Level& level = levels_[index(k)];
    level.params = at;
    level.step = by_quarter(at, check && k == 0) ? 2 : 1;
    if (k > 0) {
      level.left_grey = arena.take_image<std::uint8_t>(width, height);
      level.right_grey = arena.take_image<std::uint8_t>(width, height);
    }
    if (k > 0 && at.prefilter_cap) {
      level.left = arena.take_image<std::uint8_t>(width, height);
      level.right = arena.take_image<std::uint8_t>(width, height);
    }
    if (k > 0 || level.step == 2) {
      const auto part = [&](int size) noexcept { return (size + level.step - 1) / level.step; };
      level.found = arena.take_image<std::int16_t>(part(width), part(height));
    }
    take_search(level, k + 1 == count_, check && k == 0, width, height, arena);
    at = coarser(at);
    width = halved(width);
    height = halved(height);
  }
}

void CoarseToFine::take_search(Level& level, bool coarsest, bool check, int width, int height,
                               Arena& arena) noexcept {
  const MatchParams& params = level.params;
  if (level.step == 2 || by_strips(params, coarsest)) {
    level.strips.emplace(params, check, width, height, arena);
    return;
  }
  if (wide(params)) {
    level.wide_patches.emplace(params, check, width, height, arena);
  } else {
    level.patches.emplace(params, check, width, height, arena);
  }
  level.ranges = arena.take<CandidateRange>(index(PatchSearch<std::uint16_t>::patches(width)));
}

// The pictures of the next coarser size.
void CoarseToFine::halve_into(const Level& fine, Level& coarse) noexcept {
  halve(fine.pictures.left_grey, coarse.left_grey);
  halve(fine.pictures.right_grey, coarse.right_grey);
  coarse.pictures = {.left = coarse.left_grey,
                     .right = coarse.right_grey,
                     .left_grey = coarse.left_grey,
                     .right_grey = coarse.right_grey};
  if (!fine.params.prefilter_cap) {
    return;
  }
  const auto derive = [&](ImageView<const std::uint8_t> grey,
                          ImageView<std::uint8_t> out) noexcept {
    for (int y = 0; y < out.height(); ++y) {
      best::clipped_sobel(grey.row_clamped(y - 1), grey.row(y), grey.row_clamped(y + 1),
                          *fine.params.prefilter_cap, out.row(y));
    }
  };
  derive(coarse.left_grey, coarse.left);
  derive(coarse.right_grey, coarse.right);
  coarse.pictures.left = coarse.left;
  coarse.pictures.right = coarse.right;
}

CoarseWinners CoarseToFine::found(const Level& level) noexcept {
  return {.winners = level.winners.left,
          .step = level.step,
          .min_disparity = level.params.min_disparity,
          .disparities = level.params.disparities};
}

CandidateList CoarseToFine::candidates(const Level& level, const Level* coarse, int x,
                                       Rows rows) noexcept {
  if (coarse != nullptr) {
    return list_around(found(*coarse), level.params, x, rows);
  }
  CandidateList all;
  all.append(0, level.params.disparities - 1);
  return all;
}

void CoarseToFine::search_strips(Level& level, const Level* coarse) noexcept {
  const int width = level.pictures.left.width();
  const int height = level.pictures.left.height();
  PatchStrips& strips = *level.strips;
  strips.start(level.pictures.left, level.pictures.right);
  for (int y = 0; y < height; y += PatchStrips::kPatchHeight) {
    const Rows rows{y, std::min(y + PatchStrips::kPatchHeight, height)};
    for (int t = 0; t < PatchStrips::patches(width); ++t) {
      const CandidateList list = candidates(level, coarse, t * kPatchColumns, rows);
      if (level.step == 2) {
        strips.search_quarter(rows, t, list.view(), level.winners.left);
      } else {
        strips.search(rows, t, list.view(), level.winners);
      }
    }
  }
}

template <typename Sum>
void CoarseToFine::search(Level& level, PatchSearch<Sum>& patches, const Level* coarse) noexcept {
  const ImageView<std::int16_t> map = level.winners.left;
  const std::span<CandidateRange> ranges = level.ranges;
  patches.start(level.pictures.left, level.pictures.right);
  std::ranges::fill(ranges, CandidateRange{0, patches.lanes()});
  if (coarse == nullptr && level.winners.right.empty()) {
    patches.search(map.rows(), ranges, level.winners);
    return;
  }
  for (int y = 0; y < map.height(); y += PatchSearch<Sum>::kPatchHeight) {
    const Rows rows{y, std::min(y + PatchSearch<Sum>::kPatchHeight, map.height())};
    for (std::size_t t = 0; coarse != nullptr && t < ranges.size(); ++t) {
      ranges[t] =
          range_around(found(*coarse), level.params, static_cast<int>(t) * kPatchColumns, rows);
    }
    patches.search(rows, ranges, level.winners);
  }
}

void CoarseToFine::match(const PyramidPictures& pictures, const PatchWinners& winners) noexcept {
  STOF_CHECK(same_size(pictures.left, winners.left));
  if (pictures.left.empty()) {
    return;
  }
  levels_[0].pictures = pictures;
  levels_[0].winners = winners;
  for (int k = 0; k < count_; ++k) {
    Level& level = levels_[index(k)];
    if (k > 0) {
      halve_into(levels_[index(k - 1)], level);
    }
    if (!level.found.empty()) {
      level.winners = {.left = level.found, .right = {}};
    }
  }
  for (int k = count_ - 1; k >= 0; --k) {
    Level& level = levels_[index(k)];
    const Level* const coarse = k + 1 < count_ ? &level + 1 : nullptr;
    if (level.strips) {
      search_strips(level, coarse);
    } else if (level.wide_patches) {
      search(level, *level.wide_patches, coarse);
    } else {
      search(level, *level.patches, coarse);
    }
  }
  if (levels_[0].step == 2) {
    spread(levels_[0].params, levels_[0].found, winners.left);
  }
}

}  // namespace stof::lab
