#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/check.h"
#include "dsp/stereo/search/block_winners.h"
#include "dsp/stereo/search/winner.h"

// peak_ratio() of the vector variants. Isa is the vocabulary of one of them:
//   lowest(costs, near, count)     the lowest of `count` elements of (costs | near)
//   put_ratios(own, rival, shift, to)
//                                  of kAtOnce pixels: floor(255 c / r), or 255 where c >= r or the
//                                  rival is kNoCost; c and r are what both are without their lowest
//                                  `shift` bits
namespace stof::dsp::peak_ratio_body {

inline constexpr std::size_t kAtOnce = 16;

template <typename Isa, typename Sum>
class Ratios {
 public:
  // Of whole times kAtOnce pixels; returns their number.
  static std::size_t find(std::span<const Sum> costs, int lanes, bool numbered,
                          std::span<const std::int16_t> winners,
                          std::span<std::uint8_t> ratio) noexcept {
    const std::size_t count = static_cast<std::size_t>(lanes);
    STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && count <= kMostLanes &&
               costs.size() == winners.size() * count && ratio.size() == winners.size());
    STOF_CHECK(!numbered || sizeof(Sum) == sizeof(std::uint16_t));
    const int shift = numbered ? std::countr_zero(unsigned{kBlockSumScale}) : 0;
    const std::size_t all = winners.size() / kAtOnce * kAtOnce;
    if (count == 64) {  // a known count is unrolled
      run<64>(costs.data(), count, shift, winners.first(all), ratio.data());
    } else {
      run<0>(costs.data(), count, shift, winners.first(all), ratio.data());
    }
    return all;
  }

 private:
  static constexpr std::size_t kMostLanes = 256;
  // From kMostLanes - i on, lane k is all ones where |k - i| <= 1.
  static constexpr auto kNear = [] {
    std::array<Sum, 2 * kMostLanes + 1> near{};
    near[kMostLanes - 1] = near[kMostLanes] = near[kMostLanes + 1] = kNoCost<Sum>;
    return near;
  }();

  template <std::size_t kCount>
  static void run(const Sum* costs, std::size_t lanes, int shift,
                  std::span<const std::int16_t> winners, std::uint8_t* ratio) noexcept {
    const std::size_t count = kCount == 0 ? lanes : kCount;
    const std::int16_t* winner = winners.data();
    const std::int16_t* const end = winner + winners.size();
    while (winner != end) {
      std::array<Sum, kAtOnce> own;
      std::array<Sum, kAtOnce> rival;
      for (std::size_t k = 0; k < kAtOnce; ++k) {
        const std::ptrdiff_t i = *winner++;
        own[k] = costs[std::max<std::ptrdiff_t>(i, 0)];
        rival[k] = i == kNoWinner ? kNoCost<Sum>
                                  : Isa::lowest(costs, kNear.data() + kMostLanes - i, count);
        costs += count;
      }
      Isa::put_ratios(own.data(), rival.data(), shift, ratio);
      ratio += kAtOnce;
    }
  }
};

}  // namespace stof::dsp::peak_ratio_body
