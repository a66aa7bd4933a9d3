#include "lab/pyramid/patch_sums.h"

#include <array>
#include <cstddef>
#include <cstdlib>

#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "dsp/stereo/match_params.h"

namespace stof::dsp::ref {
namespace {

// What row y of the pictures adds to the block of column x.
int row_sum(const PatchPlace& patch, int y, int x, int candidate) noexcept {
  const std::span<const std::uint8_t> left = patch.left.row_clamped(y);
  const std::span<const std::uint8_t> right = patch.right.row_clamped(y);
  int sum = 0;
  for (int k = x; k < x + patch.block_width; ++k) {
    sum += std::abs(left[index(patch.left_x + k)] - right[index(patch.right_x + k - candidate)]);
  }
  return sum;
}

}  // namespace

void start_patch(const PatchPlace& patch, Rows rows, std::span<std::uint16_t> sums) noexcept {
  STOF_CHECK(sums.size() == patch.candidates.size() * kPatchColumns);
  for (std::size_t i = 0; i < patch.candidates.size(); ++i) {
    for (int x = 0; x < kPatchColumns; ++x) {
      int sum = 0;
      for (int y = rows.begin; y < rows.end; ++y) {
        sum += row_sum(patch, y, x, patch.candidates[i]);
      }
      sums[i * kPatchColumns + index(x)] =
          static_cast<std::uint16_t>(kPatchSumScale * sum + static_cast<int>(i % kPatchSumScale));
    }
  }
}

void slide_patch(const PatchPlace& patch, int entering, int leaving,
                 std::span<std::uint16_t> sums) noexcept {
  STOF_CHECK(sums.size() == patch.candidates.size() * kPatchColumns);
  for (std::size_t i = 0; i < patch.candidates.size(); ++i) {
    for (int x = 0; x < kPatchColumns; ++x) {
      std::uint16_t& sum = sums[i * kPatchColumns + index(x)];
      const int change = row_sum(patch, entering, x, patch.candidates[i]) -
                         row_sum(patch, leaving, x, patch.candidates[i]);
      sum = static_cast<std::uint16_t>(sum + kPatchSumScale * change);
    }
  }
}

void find_in_patch(std::span<const std::uint16_t> sums, std::span<const std::int16_t> candidates,
                   const PatchLimits& limits, std::span<std::int16_t> winners) noexcept {
  STOF_CHECK(sums.size() == candidates.size() * kPatchColumns && winners.size() <= kPatchColumns);
  for (std::size_t x = 0; x < winners.size(); ++x) {
    int lowest = 0;
    bool differ = false;
    winners[x] = kNoWinner;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const int column = static_cast<int>(x) - candidates[i];
      if (column < limits.begin || column >= limits.end) {
        continue;
      }
      const int cost = sums[i * kPatchColumns + x] / kPatchSumScale;
      differ = differ || (winners[x] != kNoWinner && cost != lowest);
      if (winners[x] == kNoWinner || cost < lowest) {
        winners[x] = candidates[i];
        lowest = cost;
      }
    }
    winners[x] = differ ? winners[x] : kNoWinner;
  }
}

void offer_to_right(std::span<const std::uint16_t> sums, std::int16_t candidate,
                    std::span<std::uint16_t> lowest, std::span<std::int16_t> winners) noexcept {
  STOF_CHECK(sums.size() == lowest.size() && sums.size() == winners.size());
  for (std::size_t x = 0; x < sums.size(); ++x) {
    const auto cost = static_cast<std::uint16_t>(sums[x] / kPatchSumScale);
    if (cost < lowest[x]) {
      lowest[x] = cost;
      winners[x] = candidate;
    }
  }
}

void find_quarter(const PatchPlace& patch, Rows rows, int block_height, const PatchLimits& limits,
                  ImageView<std::int16_t> winners) noexcept {
  STOF_CHECK(winners.width() <= kQuarterColumns && winners.height() <= kQuarterRows &&
             winners.height() == (rows.count() + 1) / 2);
  std::array<std::uint16_t, index(kMaxDisparities) * kPatchColumns> sums{};
  std::array<std::int16_t, kPatchColumns> found{};
  const std::span<std::uint16_t> used =
      std::span(sums).first(patch.candidates.size() * kPatchColumns);
  for (int r = 0; r < winners.height(); ++r) {
    const int first = rows.begin + 2 * r - block_height / 2;
    start_patch(patch, {first, first + block_height}, used);
    find_in_patch(used, patch.candidates, limits, found);
    for (int k = 0; k < winners.width(); ++k) {
      winners.at(k, r) = found[index(2 * k)];
    }
  }
}

}  // namespace stof::dsp::ref
