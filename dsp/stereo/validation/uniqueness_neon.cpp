#include "dsp/stereo/validation/uniqueness.h"

#include <array>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/lanes_neon.h"

namespace stof::dsp::neon {
namespace {

unsigned total(uint8x16_t v) noexcept { return vaddlvq_u8(v); }  // at most 16 a lane
unsigned total(uint16x8_t v) noexcept { return vaddvq_u16(v); }
unsigned total(uint32x4_t v) noexcept { return vaddvq_u32(v); }

// Counts all candidates below the limit, then takes away those that are no rivals.
template <typename Sum>
bool unique(const Sum* costs, std::size_t lanes, std::size_t winner, int percent) noexcept {
  const Sum limit = uniqueness_limit(costs[winner], percent);
  using L = Lanes<Sum>;
  const auto limits = L::all(limit);
  auto below = L::all(0);
  for (std::size_t i = 0; i < lanes; i += L::kLanes) {
    below = below - L::less(L::load(costs + i), limits);  // a true mask is -1
  }
  const bool before = winner > 0 && costs[winner - 1] < limit;
  const bool after = winner + 1 < lanes && costs[winner + 1] < limit;
  const unsigned near = 1U + static_cast<unsigned>(before) + static_cast<unsigned>(after);
  return total(below) == near;
}

}  // namespace

template <typename Sum>
void uniqueness_check(std::span<const Sum> costs, int lanes, int percent,
                      std::span<std::int16_t> winners) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  const std::size_t n = winners.size();
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && lanes <= 256 && percent >= 0 &&
             percent <= 1000 && costs.size() == n * count);
  std::size_t x = 0;
  for (; x + 8 <= n; x += 8) {
    std::array<std::uint16_t, 8> drop{};
    for (std::size_t k = 0; k < 8; ++k) {
      const std::int16_t winner = winners[x + k];
      const Sum* const pixel = costs.data() + (x + k) * count;
      if (winner != kNoWinner && pixel[winner] != kNoCost<Sum> &&
          !unique(pixel, count, static_cast<std::size_t>(winner), percent)) {
        drop[k] = 0xFFFF;
      }
    }
    std::int16_t* const at = winners.data() + x;
    vst1q_s16(at, vbslq_s16(vld1q_u16(drop.data()), vdupq_n_s16(kNoWinner), vld1q_s16(at)));
  }
  ref::uniqueness_check(costs.subspan(x * count), lanes, percent, winners.subspan(x));
}

STOF_INSTANTIATE(UniquenessCheck, uniqueness_check, std::uint8_t, std::uint16_t, std::uint32_t);

}  // namespace stof::dsp::neon
