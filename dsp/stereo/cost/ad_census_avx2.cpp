#include "dsp/stereo/cost/ad_census_body.h"
#include "dsp/stereo/cost/hamming_avx2.h"

namespace stof::dsp::avx2 {
namespace {

struct Isa : Hamming {
  // Bytes have no shift.
  static V grey_costs(V a, V b) noexcept {
    const __m256i costs = _mm256_broadcastsi128_si256(
        _mm_setr_epi8(0, 1 >> kAdCensusGreyShift, 2 >> kAdCensusGreyShift, 3 >> kAdCensusGreyShift,
                      4 >> kAdCensusGreyShift, 5 >> kAdCensusGreyShift, 6 >> kAdCensusGreyShift, 0,
                      0, 0, 0, 0, 0, 0, 0, 0));
    static_assert(kAdCensusGreyCap == 6);
    const V capped = smaller(difference(a, b), all(kAdCensusGreyCap));
    return as<V>(_mm256_shuffle_epi8(costs, bits(capped)));
  }
};

}  // namespace

void ad_census_costs(const AdCensusRow& left, const AdCensusRow& right, int lanes,
                     std::span<std::uint8_t> costs) noexcept {
  if (lanes % static_cast<int>(Isa::kLanes) != 0) {
    neon::ad_census_costs(left, right, lanes, costs);
    return;
  }
  ad_census_body::costs_of<Isa>(left, right, lanes, costs);
}

}  // namespace stof::dsp::avx2
