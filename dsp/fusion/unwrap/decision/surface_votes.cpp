#include "dsp/fusion/unwrap/decision/surface_votes.h"

#include <algorithm>
#include <array>

#include "dsp/base/index.h"

namespace stof::dsp {
namespace {

constexpr std::size_t kPerWord = 4;
constexpr std::size_t kBits = 16;  // of a count: at most (2 kArm + 1) times a height of 4096
constexpr std::size_t kMostWords = kMostWrapCounts / kPerWord + 1;

// What a pixel adds to a word of sums, by its vote less kNoReading.
using WordCounts = std::array<std::uint64_t, kMostWrapCounts - kNoReading>;
WordCounts counts_of(std::size_t word) noexcept {
  WordCounts counts;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    const int vote = static_cast<int>(k) + kNoReading;
    const int place = vote + 1 - static_cast<int>(word * kPerWord);  // in the word
    const bool counted = vote >= 0 && place >= 0 && place < static_cast<int>(kPerWord);
    counts[k] = (word == 0 ? 1U : 0U) +
                (counted ? std::uint64_t{1} << (kBits * index(place)) : std::uint64_t{0});
  }
  return counts;
}

// How many of the kArm first links are whole: 1 each, 0 where the surface ends. step: to the next.
std::uint8_t unbroken(const std::uint8_t* link, std::ptrdiff_t step) noexcept {
  std::uint8_t run = 1;
  std::uint8_t arm = 0;
  for (int i = 0; i < SurfaceVotes::kArm; ++i) {
    run = static_cast<std::uint8_t>(run & link[i * step]);
    arm = static_cast<std::uint8_t>(arm + run);
  }
  return arm;
}

// Those of pixels above or below, one longer where the link to them is whole.
void lengthen(std::span<const SurfaceLink> links, std::span<const std::uint8_t> arms,
              std::span<std::uint8_t> out) noexcept {
  constexpr std::uint8_t kMost = SurfaceVotes::kArm;
  for (std::size_t x = 0; x < out.size(); ++x) {
    const std::uint8_t more = static_cast<std::uint8_t>(arms[x] + 1);
    const std::uint8_t arm = more < kMost ? more : kMost;
    out[x] = links[x] == 0 ? arm : std::uint8_t{0};
  }
}

}  // namespace

SurfaceVotes::SurfaceVotes(int width, int height, Arena& arena) noexcept
    : width_(width),
      height_(height),
      right_(arena.take_passing<std::int8_t>(pixel_count(width, height))),
      below_(arena.take_passing<std::int8_t>(pixel_count(width, height))),
      left_arm_(arena.take_passing<std::uint8_t>(pixel_count(width, height))),
      right_arm_(arena.take_passing<std::uint8_t>(pixel_count(width, height))),
      upper_arm_(arena.take_passing<std::uint8_t>(pixel_count(width, height))),
      lower_arm_(arena.take_passing<std::uint8_t>(pixel_count(width, height))),
      whole_(arena.take_filled(index(width) + 2 * index(kArm), std::uint8_t{0})),
      line_(arena.take_passing<std::uint64_t>(kMostWords * index(width + 1))),
      columns_(arena.take_passing<std::uint64_t>(kMostWords * pixel_count(width, height + 1))) {}

// Arms end at the wrap: behind it the same surface has wrapped once more, or once less. Loops
// without branches over local spans, which bytes that are written cannot change: so compilers make
// vectors of them.
void SurfaceVotes::reach() noexcept {
  const std::size_t row = index(width_);
  const auto arms = [row](std::span<std::uint8_t> all, int y) noexcept {
    return all.subspan(index(y) * row, row);
  };
  std::uint8_t* const whole = &whole_[index(kArm)];
  for (int y = 0; y < height_; ++y) {
    const std::span<const SurfaceLink> right = right_row(y);
    const std::span<std::uint8_t> left_arm = arms(left_arm_, y);
    const std::span<std::uint8_t> right_arm = arms(right_arm_, y);
    for (std::size_t x = 0; x < row; ++x) {
      whole[x] = right[x] == 0 ? 1 : 0;
    }
    for (std::size_t x = 0; x < row; ++x) {
      left_arm[x] = unbroken(whole + x - 1, -1);
    }
    for (std::size_t x = 0; x < row; ++x) {
      right_arm[x] = unbroken(whole + x, 1);
    }
  }
  std::ranges::fill(arms(upper_arm_, 0), std::uint8_t{0});
  for (int y = 1; y < height_; ++y) {
    lengthen(below_row(y - 1), arms(upper_arm_, y - 1), arms(upper_arm_, y));
  }
  std::ranges::fill(arms(lower_arm_, height_ - 1), std::uint8_t{0});
  for (int y = height_ - 2; y >= 0; --y) {
    lengthen(below_row(y), arms(lower_arm_, y + 1), arms(lower_arm_, y));
  }
}

void SurfaceVotes::sum_row(int y, std::span<const std::int8_t> votes) noexcept {
  const std::size_t row = index(width_);
  const std::size_t first = pixel_count(width_, y);
  const std::size_t words = words_;  // a word that is written could be a member
  const std::int8_t* const vote = votes.data() + first;
  const std::uint8_t* const left = left_arm_.data() + first;
  const std::uint8_t* const right = right_arm_.data() + first;
  std::uint64_t* const line = line_.data();
  for (std::size_t word = 0; word < words; ++word) {
    const WordCounts counts = counts_of(word);
    std::uint64_t sum = 0;
    line[0] = 0;
    for (std::size_t x = 0; x < row; ++x) {
      sum += counts[static_cast<std::size_t>(vote[x] - kNoReading)];
      line[x + 1] = sum;
    }
    const std::uint64_t* above = columns_.data() + first * words + word;
    std::uint64_t* here = columns_.data() + (first + row) * words + word;
    for (std::size_t x = 0; x < row; ++x) {
      *here = *above + line[x + right[x] + 1] - line[x - left[x]];
      here += words;
      above += words;
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
