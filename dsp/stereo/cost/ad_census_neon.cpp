#include "dsp/stereo/cost/ad_census.h"

#include <cstddef>

#include "dsp/base/check.h"
#include "dsp/base/simd.h"
#include "dsp/stereo/cost/hamming_neon.h"

namespace stof::dsp::neon {
namespace {

constexpr std::size_t kPlanes = planes_of(kCensus5x5Bits);

// What differs from pixel to pixel: a left column, or the first of its candidates.
struct Pixel {
  Planes planes;
  const std::uint8_t* grey;
};

Pixel pixel_of(const AdCensusRow& row, std::size_t at) noexcept {
  return {{row.planes.data() + at, row.grey.size()}, row.grey.data() + at};
}

template <std::size_t kVectors>
void strip(const Pixel& left, const Pixel& right, std::uint8_t* costs) noexcept {
  uint8x16_t sums[kVectors];
  hamming_distances<kPlanes>(left.planes, right.planes, sums);
  const uint8x16_t grey = vdupq_n_u8(*left.grey);
  const uint8x16_t cap = vdupq_n_u8(kAdCensusGreyCap);
  for (std::size_t v = 0; v < kVectors; ++v) {
    const uint8x16_t difference = vminq_u8(vabdq_u8(grey, vld1q_u8(right.grey + 16 * v)), cap);
    vst1q_u8(costs + 16 * v, vaddq_u8(sums[v], vshrq_n_u8(difference, kAdCensusGreyShift)));
  }
}

}  // namespace

void ad_census_costs(const AdCensusRow& left, const AdCensusRow& right, int lanes,
                     std::span<std::uint8_t> costs) noexcept {
  STOF_CHECK(lanes >= kCostLanes && lanes % kCostLanes == 0 && !costs.empty());
  const std::size_t count = static_cast<std::size_t>(lanes);
  const std::size_t n = costs.size() / count;
  const std::size_t candidates = n + count - 1;
  STOF_CHECK(costs.size() == n * count && left.planes.size() == kPlanes * n &&
             right.planes.size() == kPlanes * candidates);
  STOF_CHECK(left.grey.size() == n && right.grey.size() == candidates);
  for (std::size_t k = 0; k < n; ++k) {
    const Pixel own = pixel_of(left, k);
    const std::size_t first = n - 1 - k;
    std::uint8_t* const out = costs.data() + k * count;
    std::size_t i = 0;
    for (; i + 64 <= count; i += 64) {
      strip<4>(own, pixel_of(right, first + i), out + i);
    }
    for (; i < count; i += 16) {
      strip<1>(own, pixel_of(right, first + i), out + i);
    }
  }
}

}  // namespace stof::dsp::neon
