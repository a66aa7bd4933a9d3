#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "dsp/base/check.h"
#include "dsp/stereo/search/winner.h"

// right_winners() of the wide variants. Isa is the vocabulary of one of them and of Lane, u8 or
// u16:
//   V, kLanes, load, all, either (bitwise or), next (+ 1)
//   meet(costs, candidate, lowest, winner)
//                            where costs are below the lowest, both become these
//   meet_all(column, lanes, lowest, winner)
//                            may be missing: that for candidates 0 .. lanes - 1 of kLanes pixels,
//                            of which the first one meets `column` as its candidate 0
//   store(lowest, winner, to_lowest, to_winners)
//                            winners as i16, kNoWinner where the lowest is kNoCost
namespace stof::dsp::right_winners_body {

// A right pixel meets its candidates along a diagonal of the costs, its neighbour along the next
// one: a vector of right pixels reads a vector of each column, and the lowest costs stay in
// registers. Where only some of them have a candidate in a column, the others' lanes read what
// belongs to the columns beside it, and are masked.
template <typename Isa>
class RightPixels {
 public:
  using Lane = typename Isa::Lane;
  using V = typename Isa::V;
  static constexpr std::size_t kCount = Isa::kLanes;
  static constexpr int kLanes = static_cast<int>(kCount);

  struct Found {
    V lowest;
    V candidates;  // mean nothing where lowest is kNoCost
  };

  // lanes >= kLanes.
  RightPixels(std::span<const Lane> costs, int lanes) noexcept
      : costs_(costs.data()), lanes_(lanes), last_(static_cast<int>(costs.size()) / lanes - 1) {
    first_column_.fill(kNoCost<Lane>);
    last_column_.fill(kNoCost<Lane>);
    std::ranges::copy(costs.first(kCount), first_column_.begin() + kLanes);
    std::ranges::copy(costs.last(kCount), last_column_.begin());
  }

  // Of right pixels j .. j + kLanes - 1, of which the first one meets column last_ - j + i as its
  // candidate i.
  Found find(int j) const noexcept {
    Found found{.lowest = Isa::all(kNoCost<Lane>), .candidates = Isa::all(0)};
    if constexpr (requires { &Isa::meet_all; }) {
      // Columns last_ - j - kLanes .. last_ - j + lanes_ - 1 are read.
      if (j >= lanes_ - 1 && j + kLanes <= last_) {
        const Lane* const column = costs_ + static_cast<std::ptrdiff_t>(last_ - j) * lanes_;
        Isa::meet_all(column, lanes_, found.lowest, found.candidates);
        return found;
      }
    }
    int i = std::max(j - last_, 1 - kLanes);
    std::array<Lane, kCount> numbers;
    for (std::size_t k = 0; k < kCount; ++k) {
      numbers[k] = static_cast<Lane>(i + static_cast<int>(k));
    }
    V candidates = Isa::load(numbers.data());
    const Lane* at = costs_ + static_cast<std::ptrdiff_t>(last_ - j + i) * lanes_ + i;
    const auto meet = [&](V costs) noexcept {
      Isa::meet(costs, candidates, found.lowest, found.candidates);
      candidates = Isa::next(candidates);
      at += lanes_ + 1;
    };
    const auto masked = [&](int mask) noexcept {
      return Isa::either(Isa::load(at), Isa::load(kMasks.data() + mask));
    };
    if (i < 0 && i == j - last_) {
      meet(Isa::load(first_column_.data() + kLanes + i));
      ++i;
    }
    for (; i < 0; ++i) {
      meet(masked(kLanes + i));
    }
    for (; i <= std::min(j, lanes_ - kLanes); ++i) {
      meet(Isa::load(at));
    }
    for (; i < std::min(j, lanes_); ++i) {
      meet(masked(2 * kLanes - (lanes_ - i)));
    }
    if (i == j && j < lanes_) {
      meet(Isa::load(last_column_.data() + kLanes - (lanes_ - i)));
    }
    return found;
  }

 private:
  // Ends a vector of candidates on either side of the middle.
  static constexpr auto kMasks = [] {
    std::array<Lane, 3 * kCount> masks{};
    std::ranges::fill_n(masks.begin(), kLanes, kNoCost<Lane>);
    std::ranges::fill_n(masks.begin() + 2 * kLanes, kLanes, kNoCost<Lane>);
    return masks;
  }();

  const Lane* costs_;
  int lanes_;
  int last_;  // column
  // Beyond these there is no memory.
  std::array<Lane, 2 * kCount> first_column_;
  std::array<Lane, 2 * kCount> last_column_;
};

// lanes: a multiple of Isa::kLanes.
template <typename Isa>
void find(std::span<const typename Isa::Lane> costs, int lanes,
          std::span<typename Isa::Lane> lowest, std::span<std::int16_t> winners) noexcept {
  const int step = static_cast<int>(Isa::kLanes);
  STOF_CHECK(lanes > 0 && lanes % step == 0);
  const RightPixels<Isa> pixels(costs, lanes);
  const int n = static_cast<int>(costs.size()) / lanes;
  STOF_CHECK(n >= 1 &&
             costs.size() == static_cast<std::size_t>(n) * static_cast<std::size_t>(lanes));
  const int right = n + lanes - 1;
  STOF_CHECK(lowest.size() == static_cast<std::size_t>(right) && winners.size() == lowest.size());
  for (int next = 0; next < right; next += step) {
    // The last vector repeats pixels of the one before rather than ending outside.
    const int j = std::min(next, right - step);
    const auto [least, candidates] = pixels.find(j);
    Isa::store(least, candidates, lowest.data() + j, winners.data() + j);
  }
}

}  // namespace stof::dsp::right_winners_body
