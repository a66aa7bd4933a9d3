#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "dsp/base/check.h"
#include "lab/pyramid/patch_boxes_body.h"

// find_in_patch() and offer_to_right() of both variants.
namespace stof::dsp::patch_sums_body {

// Whether column x has the same cost with all candidates that exist.
static bool all_tie(std::span<const std::uint16_t> sums, std::span<const std::int16_t> candidates,
                    const PatchLimits& limits, std::size_t x) noexcept {
  int cost = -1;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const int column = static_cast<int>(x) - candidates[i];
    if (column >= limits.begin && column < limits.end) {
      const int other = sums[i * kColumns + x] / kPatchSumScale;
      if (cost >= 0 && other != cost) {
        return false;
      }
      cost = other;
    }
  }
  return true;
}

// The places of the winners of a vector of columns; all ones where there is none.
template <typename Isa, bool kMasked>
typename Isa::Sums places(const std::uint16_t* sums, std::span<const std::int16_t> candidates,
                          const PatchLimits& limits, std::size_t x) noexcept {
  using Sums = typename Isa::Sums;
  const Sums none = Isa::all(kNoCost<std::uint16_t>);
  Sums lowest = none;
  Sums place = none;
  for (std::size_t first = 0; first < candidates.size(); first += kGroup) {
    const std::size_t end = std::min(first + kGroup, candidates.size());
    Sums least = none;
    for (std::size_t i = first; i < end; ++i) {
      const Sums sum = Isa::load(sums + i * kColumns + x);
      if constexpr (kMasked) {
        const int begin = limits.begin + candidates[i] - static_cast<int>(x);
        least = Isa::select(Isa::between(begin, limits.end + candidates[i] - static_cast<int>(x)),
                            Isa::smaller(least, sum), least);
      } else {
        least = Isa::smaller(least, sum);
      }
    }
    const Sums better = Isa::less(Isa::eighth(least), Isa::eighth(lowest));
    const Sums here = Isa::add(Isa::low_bits(least), Isa::all(static_cast<std::uint16_t>(first)));
    lowest = Isa::select(better, least, lowest);
    place = Isa::select(better, here, place);
  }
  return place;
}

// Candidates from their places, all of which are some.
template <typename Isa>
void number(const std::uint16_t* found, std::span<const std::int16_t> candidates,
            std::span<std::int16_t> winners) noexcept {
  const int first = candidates.front();
  std::size_t x = 0;
  if (static_cast<int>(candidates.size()) == candidates.back() - first + 1) {
    auto* const to = reinterpret_cast<std::uint16_t*>(winners.data());  // NOLINT: the same numbers
    for (; x + Isa::kBytes / 2 <= winners.size(); x += Isa::kBytes / 2) {
      Isa::store(to + x,
                 Isa::add(Isa::load(found + x), Isa::all(static_cast<std::uint16_t>(first))));
    }
  }
  for (; x < winners.size(); ++x) {
    winners[x] = candidates[found[x]];
  }
}

// Where the first candidate has won and the second costs as much: all of them may.
template <typename Isa>
bool may_tie(const std::uint16_t* sums, std::size_t count, const std::uint16_t* found) noexcept {
  typename Isa::Sums any = Isa::all(0);
  for (std::size_t x = 0; x < kColumns; x += Isa::kBytes / 2) {
    const typename Isa::Sums first = Isa::eighth(Isa::load(sums + x));
    const typename Isa::Sums second =
        count > 1 ? Isa::eighth(Isa::load(sums + kColumns + x)) : first;
    any = Isa::either(
        any, Isa::both(Isa::equal(Isa::load(found + x), Isa::all(0)), Isa::equal(first, second)));
  }
  return Isa::any(any);
}

template <typename Isa>
void find(std::span<const std::uint16_t> sums, std::span<const std::int16_t> candidates,
          const PatchLimits& limits, std::span<std::int16_t> winners) noexcept {
  STOF_CHECK(sums.size() == candidates.size() * kColumns && winners.size() <= kColumns &&
             !candidates.empty());
  alignas(32) std::uint16_t found[kColumns];
  const bool whole = limits.begin + candidates.back() <= 0 &&
                     limits.end + candidates.front() >= static_cast<int>(kColumns);
  for (std::size_t x = 0; x < kColumns; x += Isa::kBytes / 2) {
    Isa::store(found + x, whole ? places<Isa, false>(sums.data(), candidates, limits, x)
                                : places<Isa, true>(sums.data(), candidates, limits, x));
  }
  if (whole) {
    number<Isa>(found, candidates, winners);
    if (!may_tie<Isa>(sums.data(), candidates.size(), found)) {
      return;
    }
  }
  for (std::size_t x = 0; x < winners.size(); ++x) {
    const std::uint16_t place = found[x];
    if (place == kNoCost<std::uint16_t>) {
      winners[x] = kNoWinner;
      continue;
    }
    // The first one of those that exist wins where all tie.
    const bool first = place == 0 || static_cast<int>(x) - candidates[place - 1U] >= limits.end;
    winners[x] = first && all_tie(sums, candidates, limits, x) ? kNoWinner : candidates[place];
  }
}

template <typename Isa>
void offer(std::span<const std::uint16_t> sums, std::int16_t candidate,
           std::span<std::uint16_t> lowest, std::span<std::int16_t> winners) noexcept {
  STOF_CHECK(sums.size() == lowest.size() && sums.size() == winners.size());
  constexpr std::size_t kSums = Isa::kBytes / 2;
  auto* const won = reinterpret_cast<std::uint16_t*>(winners.data());  // NOLINT: the same numbers
  const typename Isa::Sums number = Isa::all(static_cast<std::uint16_t>(candidate));
  std::size_t x = 0;
  for (; x + kSums <= sums.size(); x += kSums) {
    const typename Isa::Sums cost = Isa::eighth(Isa::load(sums.data() + x));
    const typename Isa::Sums before = Isa::load(lowest.data() + x);
    const typename Isa::Sums less = Isa::less(cost, before);
    Isa::store(won + x, Isa::select(less, number, Isa::load(won + x)));
    Isa::store(lowest.data() + x, Isa::smaller(cost, before));
  }
  ref::offer_to_right(sums.subspan(x), candidate, lowest.subspan(x), winners.subspan(x));
}

}  // namespace stof::dsp::patch_sums_body
