#include "dsp/stereo/cost/candidate_mask.h"

#include <algorithm>
#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/lanes_neon.h"

namespace stof::dsp::neon {
namespace {

// One pixel: lane numbers are compared, and a lane outside becomes all ones, which is kNoCost.
template <typename Sum>
void mask_pixel(const Sum* costs, int first, int last, std::size_t lanes, Sum* out) noexcept {
  using L = Lanes<Sum>;
  const auto low = L::all(static_cast<Sum>(first));
  const auto high = L::all(static_cast<Sum>(last));
  const auto step = L::all(static_cast<Sum>(L::kLanes));
  auto lane = L::numbers();
  for (std::size_t i = 0; i < lanes; i += L::kLanes) {
    const auto outside = L::larger(L::less(lane, low), L::less(high, lane));
    L::store(out + i, L::larger(L::load(costs + i), outside));
    lane = lane + step;
  }
}

}  // namespace

template <typename Sum>
void mask_candidates(std::span<const Sum> costs, GuideRow guide, int lanes,
                     std::span<Sum> out) noexcept {
  const std::size_t count = static_cast<std::size_t>(lanes);
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && lanes <= 256 &&
             costs.size() == guide.size() * count && out.size() == costs.size());
  for (std::size_t x = 0; x < guide.size(); ++x) {
    const int first = std::max(guide[x].first - 1, 0);
    const int last = std::min(guide[x].last + 1, 255);
    const std::size_t at = x * count;
    if (first > 0 || last < lanes - 1) {
      mask_pixel(costs.data() + at, first, last, count, out.data() + at);
    } else if (out.data() != costs.data()) {
      std::ranges::copy(costs.subspan(at, count), out.subspan(at, count).begin());
    }
  }
}

STOF_INSTANTIATE(MaskCandidates, mask_candidates, std::uint8_t, std::uint16_t, std::uint32_t);

}  // namespace stof::dsp::neon
