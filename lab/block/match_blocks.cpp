#include "lab/block/match_blocks.h"

#include <algorithm>
#include <cstdlib>
#include <limits>

#include "dsp/base/check.h"
#include "dsp/stereo/search/winner.h"

namespace stof::lab {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

using Offer = BlockOffers::Offer;

bool cheaper(std::uint32_t sum, std::uint32_t area, const Offer& than) noexcept {
  return std::uint64_t{sum} * than.area < std::uint64_t{than.sum} * area || than.area == 0;
}

// |left[x] - right[x - d]|, the right border replicated.
void difference_row(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right, int d,
                    std::span<std::uint8_t> out) noexcept {
  const int last = static_cast<int>(right.size()) - 1;
  for (int x = 0; x <= last; ++x) {
    const std::size_t at = static_cast<std::size_t>(x);
    const int match = right[static_cast<std::size_t>(std::clamp(x - d, 0, last))];
    out[at] = static_cast<std::uint8_t>(std::abs(left[at] - match));
  }
}

// One candidate for all pixels of a row.
void offer_row(const Integral& integral, std::span<const Block> blocks, int y, int d,
               std::int16_t candidate, BlockOffers& best, ImageView<std::int16_t> winners,
               ImageView<std::int16_t> right_winners) noexcept {
  const int width = winners.width();
  const std::span<std::uint32_t> lowest = best.lowest.row(y);
  const std::span<std::uint32_t> highest = best.highest.row(y);
  const std::span<Offer> offers = best.offers.row(y);
  for (int x = std::max(d, 0); x < std::min(width, width + d); ++x) {
    const std::size_t at = static_cast<std::size_t>(x);
    const Block block = blocks[at];
    const std::uint32_t sum =
        integral.sum(x - block.left, y - block.up, x + block.right + 1, y + block.down + 1);
    if (sum < lowest[at]) {  // all candidates of a pixel have the same area
      lowest[at] = sum;
      winners.row(y)[at] = candidate;
    }
    highest[at] = std::max(highest[at], sum);
    const std::size_t match = static_cast<std::size_t>(x - d);
    const std::uint32_t area = static_cast<std::uint32_t>(block.width() * block.height());
    if (cheaper(sum, area, offers[match])) {
      offers[match] = {.sum = sum, .area = area};
      right_winners.row(y)[match] = candidate;
    }
  }
}

}  // namespace

BlockOffers::BlockOffers(int width, int height, Arena& arena) noexcept
    : integral(width, height, arena),
      lowest(arena.take_image<std::uint32_t>(width, height)),
      highest(arena.take_image<std::uint32_t>(width, height)),
      offers(arena.take_image<Offer>(width, height)),
      differences(arena.take<std::uint8_t>(static_cast<std::size_t>(width))) {}

void BlockOffers::clear() const noexcept {
  for (int y = 0; y < lowest.height(); ++y) {
    std::ranges::fill(lowest.row(y), kNone);
    std::ranges::fill(highest.row(y), 0U);
    std::ranges::fill(offers.row(y), Offer{.sum = kNone, .area = 0});
  }
}

void match_blocks(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                  ImageView<const Block> blocks, int min_disparity, int disparities,
                  BlockOffers& best, ImageView<std::int16_t> winners,
                  ImageView<std::int16_t> right_winners) noexcept {
  STOF_CHECK(same_size(left, right) && same_size(left, blocks) && same_size(left, winners) &&
             same_size(left, right_winners) && same_size(left, best.lowest) && disparities >= 1);
  if (left.empty()) {
    return;
  }
  best.clear();
  for (int y = 0; y < left.height(); ++y) {
    std::ranges::fill(winners.row(y), kNoWinner);
    std::ranges::fill(right_winners.row(y), kNoWinner);
  }
  for (int i = 0; i < disparities; ++i) {
    const int d = min_disparity + i;
    for (int y = 0; y < left.height(); ++y) {
      difference_row(left.row(y), right.row(y), d, best.differences);
      best.integral.add_row(best.differences, y);
    }
    for (int y = 0; y < left.height(); ++y) {
      offer_row(best.integral, blocks.row(y), y, d, static_cast<std::int16_t>(i), best, winners,
                right_winners);
    }
  }
  for (int y = 0; y < left.height(); ++y) {
    for (std::size_t x = 0; x < best.lowest.row(y).size(); ++x) {
      if (best.lowest.row(y)[x] == best.highest.row(y)[x]) {
        winners.row(y)[x] = kNoWinner;
      }
    }
  }
}

void check_blocks(ImageView<const std::int16_t> right_winners, int min_disparity, int tolerance,
                  ImageView<std::int16_t> winners) noexcept {
  STOF_CHECK(same_size(right_winners, winners) && tolerance >= 0);
  for (int y = 0; y < winners.height(); ++y) {
    const std::span<const std::int16_t> right = right_winners.row(y);
    const std::span<std::int16_t> row = winners.row(y);
    for (std::size_t x = 0; x < row.size(); ++x) {
      if (row[x] == kNoWinner) {
        continue;
      }
      const std::size_t match = x - static_cast<std::size_t>(min_disparity + row[x]);
      STOF_CHECK(match < right.size());
      if (std::abs(right[match] - row[x]) > tolerance) {  // kNoWinner cannot be: row[x] offered one
        row[x] = kNoWinner;
      }
    }
  }
}

}  // namespace stof::lab
