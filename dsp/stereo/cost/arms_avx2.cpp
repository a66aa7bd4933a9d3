#include "dsp/stereo/cost/arms.h"

#include <cstddef>

#include "dsp/base/avx2.h"
#include "dsp/base/check.h"

namespace stof::dsp::avx2 {
namespace {

constexpr std::size_t kStep = 32;

// Counts, in every lane, the steps until the first pixel that differs too much.
class Count {
 public:
  Count(u8x32 centre, int difference) noexcept
      : centre_(centre), difference_(all(static_cast<std::uint8_t>(difference))) {}

  void step(u8x32 pixel) noexcept {
    const u8x32 difference = larger(pixel, centre_) - smaller(pixel, centre_);
    alike_ &= as<u8x32>(bits(smaller(difference, difference_) == difference));
    steps_ -= alike_;  // a true mask is -1
  }
  // Where there is a first pixel it always counts.
  u8x32 at_least(std::uint8_t least) const noexcept { return larger(steps_, all(least)); }

 private:
  u8x32 centre_;
  u8x32 difference_;
  u8x32 alike_ = all(std::uint8_t{255});
  u8x32 steps_{};
};

}  // namespace

void arms_along(std::span<const std::uint8_t> row, const ArmParams& params,
                std::span<std::uint8_t> left, std::span<std::uint8_t> right) noexcept {
  STOF_CHECK(left.size() == row.size() && right.size() == row.size());
  const std::size_t n = row.size();
  const auto longest = static_cast<std::size_t>(params.longest);
  if (n < 2 * longest + kStep) {
    arms_along_columns(row, params, 0, n, left, right);
    return;
  }
  const auto count_at = [&](std::size_t x) noexcept {
    const u8x32 centre = load<u8x32>(row.data() + x);
    Count to_left(centre, params.difference);
    Count to_right(centre, params.difference);
    for (std::size_t k = 1; k <= longest; ++k) {
      to_left.step(load<u8x32>(row.data() + x - k));
      to_right.step(load<u8x32>(row.data() + x + k));
    }
    store(left.data() + x, to_left.at_least(1));
    store(right.data() + x, to_right.at_least(1));
  };
  arms_along_columns(row, params, 0, longest, left, right);
  const std::size_t last = n - longest - kStep;
  for (std::size_t x = longest; x < last; x += kStep) {
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
  for (; x + kStep <= row.size(); x += kStep) {
    Count count(load<u8x32>(row.data() + x), params.difference);
    for (const std::uint8_t* const other : others) {
      count.step(load<u8x32>(other + x));
    }
    store(arms.data() + x, count.at_least(least));
  }
  if (x < row.size()) {
    const std::uint8_t* rest[kMaxArm];
    for (std::size_t k = 0; k < others.size(); ++k) {
      rest[k] = others[k] + x;
    }
    neon::arms_across(row.subspan(x), std::span<const std::uint8_t* const>(rest, others.size()),
                      params, arms.subspan(x));
  }
}

}  // namespace stof::dsp::avx2
