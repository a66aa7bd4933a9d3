#include "dsp/stereo/search/pyramid.h"

#include <algorithm>
#include <array>

#include "dsp/base/check.h"
#include "dsp/base/target.h"
#include "dsp/stereo/cost/prefilter.h"
#include "dsp/stereo/cost/sad.h"
#include "dsp/stereo/search/pyramid_rows.h"
#include "dsp/stereo/search/tile_candidates.h"
#include "dsp/stereo/search/tile_strips.h"
#include "dsp/stereo/search/winner.h"

namespace stof::dsp {
namespace {

constexpr int kMostLevels = 2;
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
  return !check && levels(params) > 0 && TileStrips::serves(params) &&
         std::min(params.block_width, params.block_height) >= kLeastQuarterBlock;
}

// Strips are for few candidates, so not for the coarsest size.
bool by_strips(const MatchParams& params, bool coarsest) noexcept {
  return !coarsest && TileStrips::serves(params);
}

std::size_t search_bytes(const MatchParams& params, bool coarsest, bool check, int width,
                         int height) noexcept {
  if (by_strips(params, coarsest) || by_quarter(params, check)) {
    return TileStrips::bytes_needed(params, check, width, height);
  }
  const std::size_t search =
      wide(params) ? TileSearch<std::uint32_t>::bytes_needed(params, check, width, height)
                   : TileSearch<std::uint16_t>::bytes_needed(params, check, width, height);
  return search + Arena::bytes_for<CandidateRange>(
                      static_cast<std::size_t>(TileSearch<std::uint16_t>::tiles(width)));
}

// One size of the pair, and what was found in it.
struct Level {
  MatchParams params;
  PyramidPictures pictures;
  TileWinners winners;
  int step = 1;  // of every so many pixels and rows there are winners

  CoarseWinners found() const noexcept {
    return {.winners = winners.left,
            .step = step,
            .min_disparity = params.min_disparity,
            .disparities = params.disparities};
  }
};

static_assert(TileSearch<std::uint16_t>::kTileWidth == kTileColumns);

CandidateList candidates_of(const Level& level, const Level* coarse, int x, Rows rows) noexcept {
  if (coarse != nullptr) {
    return list_around(coarse->found(), level.params, x, rows);
  }
  CandidateList all;
  all.append(0, level.params.disparities - 1);
  return all;
}

void search_strips(const Level& level, const Level* coarse, Arena arena) noexcept {
  const int width = level.pictures.left.width();
  const int height = level.pictures.left.height();
  TileStrips strips(level.params, !level.winners.right.empty(), width, height, arena);
  strips.start(level.pictures.left, level.pictures.right);
  for (int y = 0; y < height; y += TileStrips::kTileHeight) {
    const Rows rows{y, std::min(y + TileStrips::kTileHeight, height)};
    for (int t = 0; t < TileStrips::tiles(width); ++t) {
      const CandidateList list = candidates_of(level, coarse, t * kTileColumns, rows);
      if (level.step == 2) {
        strips.search_quarter(rows, t, list.view(), level.winners.left);
      } else {
        strips.search(rows, t, list.view(), level.winners);
      }
    }
  }
}

template <typename Sum>
void search(const Level& level, const Level* coarse, Arena arena) noexcept {
  const ImageView<std::int16_t> map = level.winners.left;
  const bool check = !level.winners.right.empty();
  TileSearch<Sum> tiles(level.params, check, map.width(), map.height(), arena);
  tiles.start(level.pictures.left, level.pictures.right);
  const std::span<CandidateRange> ranges =
      arena.take<CandidateRange>(static_cast<std::size_t>(TileSearch<Sum>::tiles(map.width())));
  std::ranges::fill(ranges, CandidateRange{0, tiles.lanes()});
  if (coarse == nullptr && !check) {
    tiles.search(map.rows(), ranges, level.winners);
    return;
  }
  for (int y = 0; y < map.height(); y += TileSearch<Sum>::kTileHeight) {
    const Rows rows{y, std::min(y + TileSearch<Sum>::kTileHeight, map.height())};
    for (std::size_t t = 0; coarse != nullptr && t < ranges.size(); ++t) {
      ranges[t] =
          range_around(coarse->found(), level.params, static_cast<int>(t) * kTileColumns, rows);
    }
    tiles.search(rows, ranges, level.winners);
  }
}

// Room for what is found, of every second pixel and row where that is enough.
void take_winners(Level& level, Arena& arena) noexcept {
  level.step = by_quarter(level.params, false) ? 2 : 1;
  const auto part = [&](int size) noexcept { return (size + level.step - 1) / level.step; };
  level.winners.left = arena.take_image<std::int16_t>(part(level.pictures.left.width()),
                                                      part(level.pictures.left.height()));
}

// The pictures of the next coarser size, from the arena.
Level coarser(const Level& fine, Arena& arena) noexcept {
  const int width = halved(fine.pictures.left.width());
  const int height = halved(fine.pictures.left.height());
  const auto left = arena.take_image<std::uint8_t>(width, height);
  const auto right = arena.take_image<std::uint8_t>(width, height);
  halve(fine.pictures.left_grey, left);
  halve(fine.pictures.right_grey, right);
  Level level{.params = coarser(fine.params),
              .pictures = {.left = left, .right = right, .left_grey = left, .right_grey = right},
              .winners = {.left = {}, .right = {}}};
  take_winners(level, arena);
  if (!fine.params.prefilter_cap) {
    return level;
  }
  const auto derive = [&](ImageView<const std::uint8_t> grey) noexcept {
    const auto out = arena.take_image<std::uint8_t>(width, height);
    for (int y = 0; y < height; ++y) {
      best::clipped_sobel(grey.row_clamped(y - 1), grey.row(y), grey.row_clamped(y + 1),
                          *fine.params.prefilter_cap, out.row(y));
    }
    return out;
  };
  level.pictures.left = derive(left);
  level.pictures.right = derive(right);
  return level;
}

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

std::size_t pyramid_bytes_needed(const MatchParams& params, int width, int height) noexcept {
  std::size_t search = search_bytes(params, levels(params) == 0, true, width, height);
  const std::size_t quarter =
      static_cast<std::size_t>(halved(width)) * static_cast<std::size_t>(halved(height));
  std::size_t bytes = Arena::bytes_for<std::int16_t>(by_quarter(params, false) ? quarter : 0);
  MatchParams level = params;
  for (int k = 0; k < levels(params); ++k) {
    level = coarser(level);
    width = halved(width);
    height = halved(height);
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    bytes += 4 * Arena::bytes_for<std::uint8_t>(pixels) + Arena::bytes_for<std::int16_t>(pixels);
    search = std::max(search, search_bytes(level, k + 1 == levels(params), false, width, height));
  }
  return bytes + search;
}

void match_coarse_to_fine(const MatchParams& params, const PyramidPictures& pictures, Arena arena,
                          const TileWinners& winners) noexcept {
  STOF_CHECK(levels(params) <= kMostLevels && same_size(pictures.left, winners.left));
  if (pictures.left.empty()) {
    return;
  }
  std::array<Level, kMostLevels + 1> sizes{{{params, pictures, winners}, {}, {}}};
  for (std::size_t k = 0; k < static_cast<std::size_t>(levels(params)); ++k) {
    sizes[k + 1] = coarser(sizes[k], arena);
  }
  const bool quarter = by_quarter(params, !winners.right.empty());
  if (quarter) {
    take_winners(sizes[0], arena);
  }
  for (int k = levels(params); k >= 0; --k) {
    const Level& level = sizes[static_cast<std::size_t>(k)];
    const Level* const coarse = k < levels(params) ? &level + 1 : nullptr;
    if (level.step == 2 || by_strips(level.params, coarse == nullptr)) {
      search_strips(level, coarse, arena);
    } else if (wide(level.params)) {
      search<std::uint32_t>(level, coarse, arena);
    } else {
      search<std::uint16_t>(level, coarse, arena);
    }
  }
  if (quarter) {
    spread(params, sizes[0].winners.left, winners.left);
  }
}

}  // namespace stof::dsp
