#include "dsp/stereo/cost/ad_census.h"

#include <cstddef>

#include "dsp/base/avx2.h"
#include "dsp/base/check.h"
#include "dsp/stereo/cost/hamming_avx2.h"

namespace stof::dsp::avx2 {
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

u8x32 distance(u8x32 a, u8x32 b) noexcept { return larger(a, b) - smaller(a, b); }

// Bytes have no shift.
u8x32 capped_share(u8x32 difference) noexcept {
  const __m256i shares = _mm256_broadcastsi128_si256(
      _mm_setr_epi8(0, 1 >> kAdCensusGreyShift, 2 >> kAdCensusGreyShift, 3 >> kAdCensusGreyShift,
                    4 >> kAdCensusGreyShift, 5 >> kAdCensusGreyShift, 6 >> kAdCensusGreyShift, 0, 0,
                    0, 0, 0, 0, 0, 0, 0));
  static_assert(kAdCensusGreyCap == 6);
  const u8x32 capped = smaller(difference, all(std::uint8_t{kAdCensusGreyCap}));
  return as<u8x32>(_mm256_shuffle_epi8(shares, bits(capped)));
}

template <std::size_t kVectors>
void strip(const Pixel& left, const Pixel& right, std::uint8_t* costs) noexcept {
  u8x32 sums[kVectors];
  hamming_distances<kPlanes>(left.planes, right.planes, sums);
  const u8x32 grey = all(*left.grey);
  for (std::size_t v = 0; v < kVectors; ++v) {
    store(costs + 32 * v, sums[v] + capped_share(distance(grey, load<u8x32>(right.grey + 32 * v))));
  }
}

}  // namespace

void ad_census_costs(const AdCensusRow& left_row, const AdCensusRow& right_row, int lanes,
                     std::span<std::uint8_t> costs) noexcept {
  if (lanes % 32 != 0) {
    neon::ad_census_costs(left_row, right_row, lanes, costs);
    return;
  }
  const AdCensusRow left = left_row;  // no store changes these
  const AdCensusRow right = right_row;
  STOF_CHECK(lanes > 0 && !costs.empty());
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
      strip<2>(own, pixel_of(right, first + i), out + i);
    }
    if (i < count) {
      strip<1>(own, pixel_of(right, first + i), out + i);
    }
  }
}

}  // namespace stof::dsp::avx2
