#include "dsp/stereo/search/pyramid.h"

#include <algorithm>
#include <array>

#include "dsp/base/check.h"
#include "dsp/base/target.h"
#include "dsp/stereo/cost/prefilter.h"
#include "dsp/stereo/cost/sad.h"
#include "dsp/stereo/search/tile_strips.h"
#include "dsp/stereo/search/winner.h"

namespace stof::dsp {
namespace {

constexpr int kMostLevels = 2;
// Around what the coarser size found, in candidates of the finer size.
constexpr int kMargin = 1;
// The surroundings of a tile, in pixels of the coarser size.
constexpr int kReach = 6;
// A candidate that, with its two neighbours, fewer of the surroundings found is an error.
constexpr int kShare = 24;

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

// Strips are for few candidates, so not for the coarsest size.
bool by_strips(const MatchParams& params, bool coarsest) noexcept {
  return !coarsest && TileStrips::serves(params);
}

std::size_t search_bytes(const MatchParams& params, bool coarsest, bool check, int width,
                         int height) noexcept {
  if (by_strips(params, coarsest)) {
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
};

static_assert(TileSearch<std::uint16_t>::kTileWidth == kTileColumns);

// Which candidates the surroundings of a tile of the finer size found; none: no information.
class Surroundings {
 public:
  Surroundings(const Level& coarse, int x, Rows rows) noexcept
      : disparities_(coarse.params.disparities) {
    const ImageView<std::int16_t> map = coarse.winners.left;
    const int first_x = std::max(x / 2 - kReach, 0);
    const int end_x = std::min((x + kTileColumns - 1) / 2 + kReach + 1, map.width());
    const int first_y = std::max(rows.begin / 2 - kReach, 0);
    const int end_y = std::min((rows.end - 1) / 2 + kReach + 1, map.height());
    for (int y = first_y; y < end_y; ++y) {
      count(map.row(y).subspan(static_cast<std::size_t>(first_x),
                               static_cast<std::size_t>(end_x - first_x)));
    }
    for (std::size_t k = 1; k < kCounters; ++k) {
      for (std::size_t i = 0; i <= static_cast<std::size_t>(disparities_); ++i) {
        counts_[0][i] = static_cast<std::uint16_t>(counts_[0][i] + counts_[k][i]);
      }
    }
    const int pixels = (end_x - first_x) * (end_y - first_y) - counts_[0][0];
    counts_[0][0] = 0;
    needed_ = std::max(pixels / kShare, 1);
  }

  bool hold(int candidate) const noexcept {
    const std::size_t at = static_cast<std::size_t>(candidate) + 1;
    const auto& found = counts_[0];
    return found[at] > 0 && found[at - 1] + found[at] + found[at + 1] >= needed_;
  }

 private:
  // Equal neighbours count in different places: none waits for the one before.
  static constexpr std::size_t kCounters = 4;

  void count(std::span<const std::int16_t> winners) noexcept {
    for (std::size_t x = 0; x < winners.size(); ++x) {
      ++counts_[x % kCounters][static_cast<std::size_t>(winners[x] + 1)];
    }
  }

  int disparities_;
  int needed_ = 1;
  std::array<std::array<std::uint16_t, kMaxDisparities + 2>, kCounters>
      counts_{};  // [candidate + 1]
};

// What a tile of the finer size has to search: as one range,
CandidateRange range_around(const Level& coarse, const MatchParams& fine, int x,
                            Rows rows) noexcept {
  const Surroundings around(coarse, x, rows);
  int lowest = kMaxDisparities;
  int highest = -1;
  for (int i = 0; i < coarse.params.disparities; ++i) {
    if (around.hold(i)) {
      lowest = std::min(lowest, i);
      highest = i;
    }
  }
  const int all = lanes_of(fine);
  if (highest < 0) {
    return {0, all};
  }
  const int offset = 2 * coarse.params.min_disparity - fine.min_disparity;
  const int first = std::clamp(2 * lowest + offset - kMargin, 0, fine.disparities - 1);
  const int last = std::clamp(2 * highest + 1 + offset + kMargin, first, fine.disparities - 1);
  // Whole vectors search more for the same price: to either side.
  const int lanes = (last - first + kCostLanes) / kCostLanes * kCostLanes;
  return {std::clamp(first - (lanes - 1 - (last - first)) / 2, 0, all - lanes), lanes};
}

struct CandidateList {
  std::array<std::int16_t, kMaxDisparities> numbers{};
  std::size_t count = 0;

  std::span<const std::int16_t> view() const noexcept { return std::span(numbers).first(count); }
  // first .. last, as far as they are above those before.
  void append(int first, int last) noexcept {
    if (count > 0) {
      first = std::max(first, numbers[count - 1] + 1);
    }
    for (int i = first; i <= last; ++i) {
      numbers[count++] = static_cast<std::int16_t>(i);
    }
  }
};

// or as those alone that lie near one that was found.
CandidateList list_around(const Level& coarse, const MatchParams& fine, int x, Rows rows) noexcept {
  const Surroundings around(coarse, x, rows);
  const int offset = 2 * coarse.params.min_disparity - fine.min_disparity;
  CandidateList list;
  for (int i = 0; i < coarse.params.disparities; ++i) {
    if (around.hold(i)) {
      list.append(std::max(2 * i + offset - kMargin, 0),
                  std::min(2 * i + 1 + offset + kMargin, fine.disparities - 1));
    }
  }
  if (list.count == 0) {
    list.append(0, fine.disparities - 1);
  }
  return list;
}

void search_strips(const Level& level, const Level& coarse, Arena arena) noexcept {
  const ImageView<std::int16_t> map = level.winners.left;
  TileStrips strips(level.params, !level.winners.right.empty(), map.width(), map.height(), arena);
  strips.start(level.pictures.left, level.pictures.right);
  for (int y = 0; y < map.height(); y += TileStrips::kTileHeight) {
    const Rows rows{y, std::min(y + TileStrips::kTileHeight, map.height())};
    for (int t = 0; t < TileStrips::tiles(map.width()); ++t) {
      const CandidateList list = list_around(coarse, level.params, t * kTileColumns, rows);
      strips.search(rows, t, list.view(), level.winners);
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
      ranges[t] = range_around(*coarse, level.params, static_cast<int>(t) * kTileColumns, rows);
    }
    tiles.search(rows, ranges, level.winners);
  }
}

// The pictures of the next coarser size, from the arena.
Level coarser(const Level& fine, Arena& arena) noexcept {
  const int width = halved(fine.winners.left.width());
  const int height = halved(fine.winners.left.height());
  const auto left = arena.take_image<std::uint8_t>(width, height);
  const auto right = arena.take_image<std::uint8_t>(width, height);
  halve(fine.pictures.left_grey, left);
  halve(fine.pictures.right_grey, right);
  Level level{.params = coarser(fine.params),
              .pictures = {.left = left, .right = right, .left_grey = left, .right_grey = right},
              .winners = {.left = arena.take_image<std::int16_t>(width, height), .right = {}}};
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

}  // namespace

void halve(ImageView<const std::uint8_t> in, ImageView<std::uint8_t> out) noexcept {
  STOF_CHECK(out.width() == halved(in.width()) && out.height() == halved(in.height()));
  const std::size_t pairs = static_cast<std::size_t>(in.width() / 2);
  for (int y = 0; y < out.height(); ++y) {
    const std::span<const std::uint8_t> upper = in.row(2 * y);
    const std::span<const std::uint8_t> lower = in.row_clamped(2 * y + 1);
    const std::span<std::uint8_t> row = out.row(y);
    for (std::size_t x = 0; x < pairs; ++x) {
      const int sum = upper[2 * x] + upper[2 * x + 1] + lower[2 * x] + lower[2 * x + 1];
      row[x] = static_cast<std::uint8_t>((sum + 2) / 4);
    }
    if (pairs < row.size()) {
      row[pairs] = static_cast<std::uint8_t>((upper.back() + lower.back() + 1) / 2);
    }
  }
}

std::size_t pyramid_bytes_needed(const MatchParams& params, int width, int height) noexcept {
  std::size_t search = search_bytes(params, levels(params) == 0, true, width, height);
  std::size_t bytes = 0;
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
  for (int k = levels(params); k >= 0; --k) {
    const Level& level = sizes[static_cast<std::size_t>(k)];
    const Level* const coarse = k < levels(params) ? &level + 1 : nullptr;
    if (by_strips(level.params, coarse == nullptr)) {
      search_strips(level, *coarse, arena);
    } else if (wide(level.params)) {
      search<std::uint32_t>(level, coarse, arena);
    } else {
      search<std::uint16_t>(level, coarse, arena);
    }
  }
}

}  // namespace stof::dsp
