#include "dsp/fusion/unwrap/decision/surface_votes.h"

#include <algorithm>

#include "dsp/base/index.h"

namespace stof::dsp {
namespace {

constexpr std::size_t kPerWord = 4;
constexpr std::size_t kBits = 16;  // of a count: at most (2 kArm + 1) times a height of 4096
constexpr std::size_t kMostWords = kMostWrapCounts / kPerWord + 1;

std::uint8_t one_more(std::uint8_t arm) noexcept {
  return static_cast<std::uint8_t>(std::min(arm + 1, SurfaceVotes::kArm));
}

}  // namespace

SurfaceVotes::SurfaceVotes(int width, int height, Arena& arena) noexcept
    : width_(width),
      height_(height),
      right_(arena.take<std::int8_t>(pixel_count(width, height))),
      below_(arena.take<std::int8_t>(pixel_count(width, height))),
      left_arm_(arena.take<std::uint8_t>(pixel_count(width, height))),
      right_arm_(arena.take<std::uint8_t>(pixel_count(width, height))),
      upper_arm_(arena.take<std::uint8_t>(pixel_count(width, height))),
      lower_arm_(arena.take<std::uint8_t>(pixel_count(width, height))),
      line_(arena.take<std::uint64_t>(kMostWords * index(width + 1))),
      columns_(arena.take<std::uint64_t>(kMostWords * pixel_count(width, height + 1))) {}

// Arms end at the wrap: behind it the same surface has wrapped once more, or once less.
void SurfaceVotes::reach() noexcept {
  const std::size_t row = index(width_);
  const std::size_t all = pixel_count(width_, height_);
  for (std::size_t i = 0; i < all; ++i) {
    left_arm_[i] =
        i % row != 0 && right_[i - 1] == 0 ? one_more(left_arm_[i - 1]) : std::uint8_t{0};
    upper_arm_[i] =
        i >= row && below_[i - row] == 0 ? one_more(upper_arm_[i - row]) : std::uint8_t{0};
  }
  for (std::size_t i = all; i-- > 0;) {
    right_arm_[i] = right_[i] == 0 ? one_more(right_arm_[i + 1]) : std::uint8_t{0};
    lower_arm_[i] = below_[i] == 0 ? one_more(lower_arm_[i + row]) : std::uint8_t{0};
  }
}

void SurfaceVotes::sum_row(int y, std::span<const std::int8_t> votes) noexcept {
  const std::size_t row = index(width_);
  const std::size_t first = pixel_count(width_, y);
  for (std::size_t word = 0; word < words_; ++word) {
    const int origin = static_cast<int>(word * kPerWord) - 1;  // wrap count of the lowest count
    const std::uint64_t pixel = word == 0 ? 1 : 0;
    std::uint64_t sum = 0;
    line_[0] = 0;
    for (std::size_t x = 0; x < row; ++x) {
      const int vote = votes[first + x] - origin;
      const bool here = votes[first + x] >= 0 && vote >= 0 && vote < static_cast<int>(kPerWord);
      sum += pixel + (here ? std::uint64_t{1} << (kBits * index(vote)) : 0);
      line_[x + 1] = sum;
    }
    for (std::size_t x = 0; x < row; ++x) {
      const std::size_t i = first + x;
      columns_[(i + row) * words_ + word] =
          columns_[i * words_ + word] + line_[x + right_arm_[i] + 1] - line_[x - left_arm_[i]];
    }
  }
}

void SurfaceVotes::sum(std::span<const std::int8_t> votes, int wrap_counts) noexcept {
  words_ = index(wrap_counts) / kPerWord + 1;
  reach();
  std::ranges::fill(columns_.first(words_ * index(width_)), std::uint64_t{0});
  for (int y = 0; y < height_; ++y) {
    sum_row(y, votes);
  }
}

SurfaceVotes::Counts SurfaceVotes::around(int x, int y) const noexcept {
  const std::size_t row = index(width_);
  const std::size_t i = pixel_count(width_, y) + index(x);
  const std::size_t below = (i + (lower_arm_[i] + 1U) * row) * words_;
  const std::size_t above = (i - upper_arm_[i] * row) * words_;
  Counts out{};
  for (std::size_t n = 0; n < words_ * kPerWord; ++n) {
    const std::uint64_t word = columns_[below + n / kPerWord] - columns_[above + n / kPerWord];
    const std::size_t wraps = n == 0 ? out.size() - 1 : n - 1;
    out[wraps] = static_cast<std::uint16_t>(word >> (kBits * (n % kPerWord)));
  }
  return out;
}

}  // namespace stof::dsp
