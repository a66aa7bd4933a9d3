#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "dsp/base/check.h"
#include "dsp/stereo/search/numbered_right_winners.h"

// numbered_right_winners() of the vector variants. Isa is the vocabulary of one of them:
//   V, kLanes                      16 or 32 lanes of u16
//   load, all, smaller, either (bitwise or)
//   repeated(p)                    eight elements, over and over
//   number_where_equal(number, a, lowest)  all ones where a is above the lowest
//   winners_of(lowest, number)     lowest's group and the number in it as a candidate, 0 .. 63
//   better(a, b)                   a mask: the cost of a is below that of b, without their numbers
//   select(mask, a, b), add
//   first_of<kSkipped>(column)     what a column begins with, behind kSkipped lanes of kNoCost
//   last_of<kSkipped>(column)      what a column ends with, before kSkipped lanes of kNoCost, from
//                                  kLanes before its end on
//   store(lowest, winner, to)      kNoWinner where the lowest is kNoCost
namespace stof::dsp::numbered_right_winners_body {

// The right pixels of 64 candidates at most, from one on. As in right_winners_body.h a vector of
// right pixels reads a vector of each column; candidates that are equal modulo eight share a
// minimum.
template <typename Isa>
class Strip {
 public:
  using V = typename Isa::V;
  static constexpr int kLanes = static_cast<int>(Isa::kLanes);

  struct Found {
    V lowest;
    V winners;  // candidates from the strip's first one on
  };

  Strip(std::span<const std::uint16_t> costs, int lanes, int first, int count) noexcept
      : costs_(costs.data() + first),
        lanes_(lanes),
        count_(count),
        last_(static_cast<int>(costs.size()) / lanes - 1) {
    first_column_.fill(kNoCost<std::uint16_t>);
    last_column_.fill(kNoCost<std::uint16_t>);
    for (std::size_t k = 0; k < numbers_.size(); ++k) {
      numbers_[k] = static_cast<std::uint16_t>(k % 8);
    }
    std::copy_n(costs_, kLanes, first_column_.begin() + kLanes);
    std::copy_n(column(last_) + count_ - kLanes, kLanes, last_column_.begin());
  }

  // Of right pixels j .. j + kLanes - 1, of which the first one meets column last_ - j + i as the
  // strip's candidate i.
  Found find(int j) const noexcept {
    return j >= count_ && j + kLanes <= last_ ? find_inside(column(last_ - j)) : find_at_edge(j);
  }

 private:
  // The lowest by candidate of the first lane, modulo 8. As an argument of a template a vector
  // would lose its attributes.
  struct Eights {
    V lowest[8];
    V& operator[](std::size_t k) noexcept { return lowest[k]; }
    const V& operator[](std::size_t k) const noexcept { return lowest[k]; }
    void fill(V v) noexcept {
      for (V& each : lowest) {
        each = v;
      }
    }
  };

  const std::uint16_t* column(int x) const noexcept {
    return costs_ + static_cast<std::ptrdiff_t>(x) * lanes_;
  }

  // All of them have all candidates. at: the first one's column.
  Found find_inside(const std::uint16_t* at) const noexcept {
    Eights eights;
    eights.fill(Isa::all(kNoCost<std::uint16_t>));
    begin<kLanes - 1>(at - lanes_, eights);
    const std::ptrdiff_t step = lanes_ + 1;
    for (int i = 0; i + kLanes < count_; i += 8) {
      meet_eight(at, step, eights);
    }
    // Candidates from count_ - kLanes on, of which the first one is met by all.
    end<0>(at, eights);
    return found(eights);
  }

  // One column after the other: on ARM a load takes the step along.
  static void meet_eight(const std::uint16_t*& at, std::ptrdiff_t step, Eights& eights) noexcept {
    for (V& lowest : eights.lowest) {
      lowest = Isa::smaller(lowest, Isa::load(at));
      at += step;
    }
  }

  // What lanes from kSkipped on meet as their first candidates: candidate -kSkipped of the first
  // lane.
  template <int kSkipped>
  void begin(const std::uint16_t* at, Eights& eights) const noexcept {
    if constexpr (kSkipped > 0) {
      begin<kSkipped - 1>(at, eights);
      V& lowest = eights[static_cast<std::size_t>(2 * kLanes - kSkipped) % 8];
      lowest = Isa::smaller(
          lowest, Isa::template first_of<kSkipped>(at - std::ptrdiff_t{kSkipped - 1} * lanes_));
    }
  }
  template <int kSkipped>
  void end(const std::uint16_t* at, Eights& eights) const noexcept {
    if constexpr (kSkipped < kLanes) {
      V& lowest = eights[static_cast<std::size_t>(kSkipped) % 8];
      lowest = Isa::smaller(lowest, Isa::template last_of<kSkipped>(at));
      end<kSkipped + 1>(at + lanes_, eights);
    }
  }

  // Some have no candidate in some columns: their lanes read what belongs to the columns beside
  // it, and are masked.
  Found find_at_edge(int j) const noexcept {
    Eights eights;
    eights.fill(Isa::all(kNoCost<std::uint16_t>));
    int i = std::max(j - last_, 1 - kLanes);
    const int end = std::min(j, count_ - 1) + 1;
    const auto meet = [&](V costs) noexcept {
      V& lowest = eights[static_cast<std::size_t>(i + 2 * kLanes) % 8];
      lowest = Isa::smaller(lowest, costs);
      ++i;
    };
    const auto masked = [&](int mask) noexcept {
      return Isa::either(Isa::load(column(last_ - j + i) + i), Isa::load(kMasks.data() + mask));
    };
    if (i < 0 && i == j - last_ && i < end) {
      meet(Isa::load(first_column_.data() + kLanes + i));
    }
    while (i < std::min(0, end)) {
      meet(masked(kLanes + i));
    }
    while (i < std::min(end, count_ - kLanes + 1)) {
      meet(Isa::load(column(last_ - j + i) + i));
    }
    while (i < std::min(j, end)) {
      meet(masked(2 * kLanes - (count_ - i)));
    }
    if (i == j && i < end) {
      meet(Isa::load(last_column_.data() + kLanes - (count_ - i)));
    }
    return found(eights);
  }

  Found found(const Eights& eights) const noexcept {
    const V lowest = smallest(eights);
    Eights numbers;
    for (std::size_t k = 0; k < 8; ++k) {
      numbers[k] = Isa::number_where_equal(Isa::repeated(numbers_.data() + k), eights[k], lowest);
    }
    return {lowest, Isa::winners_of(lowest, smallest(numbers))};
  }
  static V smallest(const Eights& of) noexcept {
    return Isa::smaller(Isa::smaller(Isa::smaller(of[0], of[1]), Isa::smaller(of[2], of[3])),
                        Isa::smaller(Isa::smaller(of[4], of[5]), Isa::smaller(of[6], of[7])));
  }

  // Ends a vector of candidates on either side of the middle.
  static constexpr auto kMasks = [] {
    std::array<std::uint16_t, std::size_t{3} * kLanes> masks{};
    std::ranges::fill_n(masks.begin(), kLanes, kNoCost<std::uint16_t>);
    std::ranges::fill_n(masks.begin() + 2 * kLanes, kLanes, kNoCost<std::uint16_t>);
    return masks;
  }();
  const std::uint16_t* costs_;
  int lanes_;
  int count_;  // candidates
  int last_;   // column
  // Beyond these there may be no memory.
  std::array<std::uint16_t, std::size_t{2} * kLanes> first_column_;
  std::array<std::uint16_t, std::size_t{2} * kLanes> last_column_;
  // From k on, candidates modulo eight of the lanes whose first one has k. Here, because of
  // constants compilers make more instructions.
  std::array<std::uint16_t, 15> numbers_;
};

template <typename Isa>
void find(std::span<const std::uint16_t> costs, int lanes,
          std::span<std::int16_t> winners) noexcept {
  const int step = static_cast<int>(Isa::kLanes);
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && lanes <= 256);
  const int n = static_cast<int>(costs.size()) / lanes;
  const int right = n + lanes - 1;
  STOF_CHECK(n >= 1 &&
             costs.size() == static_cast<std::size_t>(n) * static_cast<std::size_t>(lanes) &&
             winners.size() == static_cast<std::size_t>(right));
  const auto strip = [&](int first) noexcept {
    return Strip<Isa>(costs, lanes, first, std::min(lanes - first, 64));
  };
  const std::array<Strip<Isa>, 4> strips{strip(0), strip(lanes > 64 ? 64 : 0),
                                         strip(lanes > 128 ? 128 : 0),
                                         strip(lanes > 192 ? 192 : 0)};
  for (int next = 0; next < right; next += step) {
    // The last vector repeats pixels of the one before rather than ending outside.
    const int j = std::min(next, right - step);
    auto [lowest, winner] = strips[0].find(j);
    for (int first = 64; first < lanes; first += 64) {
      const auto found = strips[static_cast<std::size_t>(first) / 64].find(j - first);
      const auto better = Isa::better(found.lowest, lowest);
      lowest = Isa::select(better, found.lowest, lowest);
      winner = Isa::select(
          better, Isa::add(found.winners, Isa::all(static_cast<std::uint16_t>(first))), winner);
    }
    Isa::store(lowest, winner, winners.data() + j);
  }
}

}  // namespace stof::dsp::numbered_right_winners_body
