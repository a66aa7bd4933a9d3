#pragma once

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/stereo/cost/arms.h"

// The NEON and the AVX2 variant of arms.h, defined for the one whose lanes are included.
namespace stof::dsp::STOF_VARIANT {
namespace {

using Isa = Lanes<std::uint8_t>;

// Counts, in every lane, the steps until the first pixel that differs too much.
class Count {
 public:
  using V = Isa::V;

  Count(V centre, int difference) noexcept
      : centre_(centre), difference_(Isa::all(static_cast<std::uint8_t>(difference))) {}

  void step(V pixel) noexcept {
    alike_ = alike_ & Isa::at_most(Isa::difference(pixel, centre_), difference_);
    steps_ = steps_ - alike_;  // a true mask is -1
  }
  // Where there is a first pixel it always counts.
  V at_least(std::uint8_t least) const noexcept { return Isa::larger(steps_, Isa::all(least)); }

 private:
  V centre_;
  V difference_;
  V alike_ = Isa::all(255);
  V steps_ = Isa::all(0);
};

}  // namespace

// NOLINTBEGIN(misc-definitions-in-headers): one source of a variant includes them
void arms_along(std::span<const std::uint8_t> row, const ArmParams& params,
                std::span<std::uint8_t> left, std::span<std::uint8_t> right) noexcept {
  STOF_CHECK(left.size() == row.size() && right.size() == row.size());
  const std::size_t n = row.size();
  const auto longest = static_cast<std::size_t>(params.longest);
  if (n < 2 * longest + Isa::kLanes) {
    arms_along_columns(row, params, 0, n, left, right);
    return;
  }
  const auto count_at = [&](std::size_t x) noexcept {
    const Isa::V centre = Isa::load(row.data() + x);
    Count to_left(centre, params.difference);
    Count to_right(centre, params.difference);
    for (std::size_t k = 1; k <= longest; ++k) {
      to_left.step(Isa::load(row.data() + x - k));
      to_right.step(Isa::load(row.data() + x + k));
    }
    Isa::store(left.data() + x, to_left.at_least(1));
    Isa::store(right.data() + x, to_right.at_least(1));
  };
  arms_along_columns(row, params, 0, longest, left, right);
  const std::size_t last = n - longest - Isa::kLanes;
  for (std::size_t x = longest; x < last; x += Isa::kLanes) {
    count_at(x);
  }
  count_at(last);  // overlaps the one before
  arms_along_columns(row, params, n - longest, n, left, right);
}

void arms_across(std::span<const std::uint8_t> row, std::span<const std::uint8_t* const> others,
                 const ArmParams& params, std::span<std::uint8_t> arms) noexcept {
  STOF_CHECK(arms.size() == row.size() && static_cast<int>(others.size()) <= params.longest);
  const std::uint8_t least = others.empty() ? 0 : 1;
  std::size_t x = 0;
  for (; x + Isa::kLanes <= row.size(); x += Isa::kLanes) {
    Count count(Isa::load(row.data() + x), params.difference);
    for (const std::uint8_t* const other : others) {
      count.step(Isa::load(other + x));
    }
    Isa::store(arms.data() + x, count.at_least(least));
  }
  if (x < row.size()) {
    const std::uint8_t* beyond[kMaxArm];
    for (std::size_t k = 0; k < others.size(); ++k) {
      beyond[k] = others[k] + x;
    }
    STOF_NARROWER::arms_across(row.subspan(x),
                               std::span<const std::uint8_t* const>(beyond, others.size()), params,
                               arms.subspan(x));
  }
}

// NOLINTEND(misc-definitions-in-headers)

}  // namespace stof::dsp::STOF_VARIANT
