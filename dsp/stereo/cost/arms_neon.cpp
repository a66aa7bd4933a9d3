#include "dsp/stereo/cost/arms.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"

namespace stof::dsp::neon {
namespace {

constexpr std::size_t kStep = 16;

// Counts, in every lane, the steps until the first pixel that differs too much.
class Count {
 public:
  Count(uint8x16_t centre, int difference) noexcept
      : centre_(centre), difference_(vdupq_n_u8(static_cast<std::uint8_t>(difference))) {}

  void step(uint8x16_t pixel) noexcept {
    alike_ = vandq_u8(alike_, vcleq_u8(vabdq_u8(pixel, centre_), difference_));
    steps_ = vsubq_u8(steps_, alike_);
  }
  // Where there is a first pixel it always counts.
  uint8x16_t at_least(std::uint8_t least) const noexcept {
    return vmaxq_u8(steps_, vdupq_n_u8(least));
  }

 private:
  uint8x16_t centre_;
  uint8x16_t difference_;
  uint8x16_t alike_ = vdupq_n_u8(255);
  uint8x16_t steps_ = vdupq_n_u8(0);
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
    const uint8x16_t centre = vld1q_u8(row.data() + x);
    Count to_left(centre, params.difference);
    Count to_right(centre, params.difference);
    for (std::size_t k = 1; k <= longest; ++k) {
      to_left.step(vld1q_u8(row.data() + x - k));
      to_right.step(vld1q_u8(row.data() + x + k));
    }
    vst1q_u8(left.data() + x, to_left.at_least(1));
    vst1q_u8(right.data() + x, to_right.at_least(1));
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
    Count count(vld1q_u8(row.data() + x), params.difference);
    for (const std::uint8_t* const other : others) {
      count.step(vld1q_u8(other + x));
    }
    vst1q_u8(arms.data() + x, count.at_least(least));
  }
  if (x < row.size()) {
    const std::uint8_t* rest[kMaxArm];
    for (std::size_t k = 0; k < others.size(); ++k) {
      rest[k] = others[k] + x;
    }
    ref::arms_across(row.subspan(x), std::span(rest).first(others.size()), params, arms.subspan(x));
  }
}

}  // namespace stof::dsp::neon
